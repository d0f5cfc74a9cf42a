#include "client/text/judgement_text.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "client/text/braille.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/figures/plant_units.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

using Column = v1::Table::Column;

constexpr int widest_name = 40;  ///< of the first column of a table that is too wide

// ANSI foreground colours of the lines of a chart, in their order.
constexpr std::array line_colours{34, 33, 32, 35, 36, 31};

/// Decimals that resolve the given resolution and no smaller differences.
int decimals_of(const Column& column, double factor) {
  if (column.resolution() <= 0.0) return 0;
  constexpr double round_off = 1e-9;
  const double digits = std::ceil(-std::log10(factor * column.resolution()) - round_off);
  return std::max(0, static_cast<int>(digits));
}

std::string cell_text(const Column& column, const v1::Cell& cell) {
  if (!cell.text().empty()) return cell.text();
  if (!cell.case_value().empty()) return shown_value(cell.case_value());
  std::string words = cell.code();
  std::ranges::replace(words, '_', ' ');
  if (!cell.has_value()) return words;

  const bool own_unit = column.unit().empty();
  const auto plant = figures::plant_unit(own_unit ? cell.unit() : column.unit());
  const int decimals = decimals_of(column, plant.factor());
  std::string text = fixed(plant.factor() * cell.value(), decimals);
  if (cell.has_until())
    text += fmt::format(" to {}", fixed(plant.factor() * cell.until(), decimals));
  if (column.is_signed() && !text.starts_with('-')) text.insert(0, "+");
  if (own_unit && !plant.name().empty()) text += fmt::format(" {}", plant.name());
  return words.empty() ? text : fmt::format("{} {}", text, words);
}

std::string error_text(const Column& column, const v1::Cell& cell) {
  if (!cell.has_upper_error()) return {};
  const double factor = figures::plant_unit(column.unit()).factor();
  const int decimals = decimals_of(column, factor);
  if (cell.lower_error() == cell.upper_error()) return fixed(factor * cell.upper_error(), decimals);
  return figures::errors_text(factor * cell.lower_error(), factor * cell.upper_error(), decimals);
}

/// A text in a column of a table; a longer one is cut.
std::string cut(const std::string& text, int width) {
  std::string shown = text;
  for (std::size_t limit = text.size(); limit > 0 && display_width(shown) > width;)
    shown = values::shortened(text, --limit);
  return shown;
}

int width_of(const std::vector<std::string>& texts, const std::string& heading) {
  int width = display_width(heading);
  for (const std::string& text : texts) width = std::max(width, display_width(text));
  return width;
}

/// Cuts the texts of a table that is wider than the page: the first column to 40 characters, the
/// others to equal shares of the rest.
void fit_page(std::vector<ShownColumn>& columns, int page_columns) {
  constexpr int narrowest = 8;
  constexpr int between = 2;
  int total = 0;
  int numbers = 0;
  int texts = 0;
  for (const ShownColumn& column : columns) {
    const int width = width_of(column.cells, column.heading) + between;
    total += width;
    if (column.has_error) total += width_of(column.errors, "± mm") + between;
    if (column.is_number)
      numbers += width;
    else
      ++texts;
  }
  if (total <= page_columns || texts == 0) return;

  ShownColumn& name = columns.front();
  for (std::string& text : name.cells) text = cut(text, widest_name);
  const int left = page_columns - numbers - width_of(name.cells, name.heading) - between;
  const int share = std::max(narrowest, left / std::max(1, texts - 1) - between);
  for (ShownColumn& column : columns) {
    if (column.is_number || &column == &name) continue;
    for (std::string& text : column.cells) text = cut(text, share);
  }
}

std::string with_unit(const std::string& heading, const std::string& unit) {
  return unit.empty() ? heading : fmt::format("{} {}", heading, unit);
}

/// Whether the bars fit beside the columns.
bool has_room(const std::vector<ShownColumn>& columns, int page_columns) {
  constexpr int bars = 17;
  constexpr int between = 2;
  int total = 0;
  for (const ShownColumn& column : columns) {
    total += width_of(column.cells, with_unit(column.heading, column.unit)) + between;
    if (column.has_error)
      total += width_of(column.errors, with_unit("\u00b1", column.unit)) + between;
  }
  return total + bars <= page_columns;
}

std::string in_capitals(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// Scales a value to the unit of the numbers.
Bar bar_of(const v1::Table& table, const v1::Table::Row& row) {
  Bar bar;
  for (int i = 0; i < row.cells_size(); ++i) {
    const v1::Cell& cell = row.cells(i);
    if (!table.columns(i).has_bars()) continue;
    if (cell.has_until()) return {cell.value(), cell.until()};

    bar.low = std::min(bar.low, cell.value());
    bar.high = std::max(bar.high, cell.value());
  }
  return bar;
}

/// "====|    ": decreases to the left, increases to the right. A range on one side of zero does not
/// touch the axis.
std::string bar_text(const Bar& bar) {
  constexpr long half = 7;
  const long first = std::lround(half * bar.low), last = std::lround(half * bar.high);

  std::string text(2 * half + 1, ' ');
  for (long i = std::max(first, -half); i <= std::min(last, half); ++i)
    text[static_cast<std::size_t>(half + i)] = '=';
  text[half] = '|';
  return text;
}

std::string coloured(const std::string& text, std::size_t line, const Terminal& terminal) {
  if (!terminal.colour) return text;
  return fmt::format("\033[{}m{}\033[0m", line_colours[line % line_colours.size()], text);
}

std::string chart_text(const v1::Chart& chart, const Terminal& terminal) {
  constexpr int rows = 6;
  constexpr int widest = 60;
  constexpr int beside = 14;  // columns for the ends of the axis
  const auto plant = figures::plant_unit(chart.y().unit());

  std::vector<BrailleLine> lines;
  std::string legend;
  for (const v1::Chart::Line& line : chart.lines()) {
    BrailleLine& drawn = lines.emplace_back();
    drawn.x.assign(line.x().begin(), line.x().end());
    for (const double y : line.y()) drawn.y.push_back(plant.factor() * y);
    if (!legend.empty()) legend += "  ";
    const std::size_t number = lines.size() - 1;
    legend += coloured(fmt::format("{} {}", braille_sample(number), line.name()), number, terminal);
  }

  const BrailleChart drawn =
      braille_chart(lines, std::min(widest, terminal.columns - beside), rows);
  std::string text = fmt::format("{}: {}\n", chart.heading(), legend);
  for (std::size_t row = 0; row < drawn.cells.size(); ++row) {
    for (const BrailleCell& cell : drawn.cells[row])
      text += cell.line ? coloured(cell.text, *cell.line, terminal) : cell.text;
    if (row == 0) text += fmt::format(" {} {}", fixed(drawn.high, 2), plant.name());
    if (row + 1 == drawn.cells.size())
      text += fmt::format(" {} {}", fixed(drawn.low, 2), plant.name());
    text += "\n";
  }
  return text;
}

}  // namespace

std::string shown_value(const std::string& value) {
  static constexpr std::string_view speed = " m/s";
  std::string text;
  for (const char* rest = value.c_str(); *rest != '\0';) {
    if (std::isdigit(static_cast<unsigned char>(*rest)) == 0) {
      if (*rest != '"') text += *rest;
      ++rest;
      continue;
    }

    char* end = nullptr;
    double number = std::strtod(rest, &end);
    rest = end;

    // " m/s2" is no speed.
    const char* const behind = rest + speed.size();
    const bool is_speed = std::string_view(rest).starts_with(speed) &&
                          std::isalnum(static_cast<unsigned char>(*behind)) == 0;
    if (is_speed) {
      number *= case_file::mm_per_min;
      rest = behind;
    }
    text += fmt::format("{:.6g}{}", number, is_speed ? " mm/min" : "");
  }
  return text;
}

std::vector<ShownColumn> shown_columns(const v1::Table& table) {
  std::vector<ShownColumn> columns;
  for (int i = 0; i < table.columns_size(); ++i) {
    const Column& column = table.columns(i);
    if (column.heading().empty()) continue;

    ShownColumn& shown = columns.emplace_back();
    shown.heading = column.heading();
    shown.unit = figures::plant_unit(column.unit()).name();
    shown.is_number = !column.unit().empty() || column.resolution() > 0.0;
    shown.has_error = column.has_error();
    for (const v1::Table::Row& row : table.rows()) {
      const v1::Cell cell = i < row.cells_size() ? row.cells(i) : v1::Cell();
      shown.cells.push_back(cell_text(column, cell));
      if (shown.has_error) shown.errors.push_back(error_text(column, cell));
    }
  }
  return columns;
}

std::vector<Bar> bars_of(const v1::Table& table) {
  std::vector<Bar> bars;
  double most = 0.0;
  for (const v1::Table::Row& row : table.rows()) {
    bars.push_back(bar_of(table, row));
    most = std::max({most, std::abs(bars.back().low), std::abs(bars.back().high)});
  }
  if (most <= 0.0) return {};

  for (Bar& bar : bars) bar = {bar.low / most, bar.high / most};
  return bars;
}

std::string table_text(const v1::Table& table, const TextStyle& style) {
  std::string text = style.headings && !table.heading().empty() ? table.heading() + "\n" : "";
  const std::string note = table.note().empty() ? "" : wrapped(table.note(), style.columns) + "\n";
  if (table.rows().empty()) return text + note;

  std::vector<ShownColumn> columns = shown_columns(table);
  fit_page(columns, style.columns);
  std::vector<std::string> headings;
  Rows rows(static_cast<std::size_t>(table.rows_size()));
  const auto add = [&](const std::string& heading, const std::string& unit, bool is_number,
                       const std::vector<std::string>& cells) {
    headings.push_back((is_number ? ">" : "") +
                       with_unit(style.capitals ? in_capitals(heading) : heading, unit));
    for (std::size_t row = 0; row < rows.size(); ++row) rows[row].push_back(cells[row]);
  };
  for (const ShownColumn& column : columns) {
    add(column.heading, column.unit, column.is_number, column.cells);
    if (column.has_error) add("\u00b1", column.unit, true, column.errors);
  }
  std::vector<std::string> bars;
  std::ranges::transform(bars_of(table), std::back_inserter(bars), bar_text);
  if (!bars.empty() && has_room(columns, style.columns)) add("   less|more", "", false, bars);
  return text + Table(headings, rows).text() + note;
}

std::string parts_text(const v1::Judgement& judgement, const Terminal& terminal,
                       const TextStyle& style) {
  std::string text;
  for (const v1::JudgementPart& part : judgement.parts()) {
    if (part.place() == v1::JudgementPart::PAGE) continue;
    if (!text.empty()) text += "\n";
    text += part.has_table() ? table_text(part.table(), style) : chart_text(part.chart(), terminal);
  }
  return text;
}

std::string sentences_text(const v1::Judgement& judgement, int columns, int indent) {
  std::string text;
  for (const std::string& sentence : judgement.sentences())
    text += wrapped(sentence, columns, 0, indent) + "\n";
  return text;
}

std::string study_judgement_text(const v1::StudyJudgement& study, const Terminal& terminal) {
  const std::string parts = parts_text(study.judgement(), terminal);
  constexpr int columns = 100;  // of text that is read, tables may be wider
  const std::string sentences = sentences_text(study.judgement(), columns, 0);
  std::string text = fmt::format("study {}: {}\n{}\n", study.study().id(), study.study().title(),
                                 study.judgement().heading());
  for (const std::string& part : {parts, sentences})
    if (!part.empty()) text += "\n" + part;
  return text;
}

}  // namespace dccast::client
