#include "client/text/comparison_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "client/model/answer.hpp"
#include "client/model/case_changes.hpp"
#include "client/text/answer_text.hpp"
#include "client/text/braille.hpp"
#include "client/text/findings.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client::render {
namespace {

// ANSI foreground colours of the lines, in the order of the answers.
constexpr std::array line_colours{34, 33, 32, 35, 36, 31};

std::string coloured(const std::string& text, std::size_t line, const Terminal& terminal) {
  if (!terminal.colour) return text;
  return "\033[" + std::to_string(line_colours[line % line_colours.size()]) + "m" + text +
         "\033[0m";
}

constexpr int page_columns = 120;
constexpr int widest_monitor = 24;

std::string signed_mm(double metres) {
  return (metres >= 0.0 ? "+" : "") + fixed(1e3 * metres, 3);
}

std::string names_text(const std::vector<Answer>& answers) {
  std::string text;
  for (std::size_t i = 0; i < answers.size(); ++i)
    text += std::to_string(i + 1) + "  " + answers[i].name +
            (answers[i].description.title().empty() ? "" : "  " + answers[i].description.title()) +
            "\n" +
            (answers[i].changes.empty() ? "" : "   " + changes_text(answers[i].changes) + "\n");
  return text;
}

/// A text in a column of a table; the end of a longer one is left out.
std::string cut(const std::string& text, int width) {
  std::string shown = text;
  for (std::size_t limit = text.size(); limit > 0 && display_width(shown) > width;)
    shown = values::shortened(text, --limit);
  return shown;
}

std::string keys_text(const std::vector<Answer>& answers) {
  const auto keys = differing_keys(answers);
  if (keys.empty()) return "the cases do not differ\n";
  std::vector<std::string> headings{"KEY"};
  for (std::size_t i = 0; i < answers.size(); ++i) headings.push_back(std::to_string(i + 1));
  constexpr int widest_key = 40, narrowest = 8;
  const int runs = static_cast<int>(answers.size());
  int key_width = 0;
  for (const KeyDifference& row : keys)
    key_width = std::max(key_width, std::min(widest_key, display_width(row.key)));
  const int value_width = std::max(narrowest, (page_columns - key_width) / runs - 2);
  Table table(headings);
  for (const KeyDifference& row : keys) {
    std::vector<std::string> cells{cut(row.key, widest_key)};
    for (const std::string& value : row.values)
      cells.push_back(cut(shown_value(value), value_width));
    table.add(std::move(cells));
  }
  return table.text();
}

std::string curves_text(const std::vector<Answer>& answers, const std::string& monitor,
                        const Terminal& terminal) {
  std::vector<BrailleLine> lines;
  std::string legend;
  const Chart chart = comparison_chart(answers, monitor);
  if (!has_curl(chart)) return "";
  for (std::size_t i = 0; i < chart.lines.size(); ++i) {
    lines.push_back({chart.lines[i].x, chart.lines[i].y});
    legend += (i == 0 ? "" : "  ") + coloured(chart.lines[i].name, i, terminal);
  }
  const BrailleChart drawn = braille_chart(lines, std::min(60, terminal.columns - 14), 6);
  std::string text = "curl of " + monitor + ": " + legend + "\n";
  for (std::size_t row = 0; row < drawn.cells.size(); ++row) {
    for (const BrailleCell& cell : drawn.cells[row])
      text += cell.line ? coloured(cell.text, *cell.line, terminal) : cell.text;
    if (row == 0) text += " " + fixed(drawn.high, 2) + " mm";
    if (row + 1 == drawn.cells.size()) text += " " + fixed(drawn.low, 2) + " mm";
    text += "\n";
  }
  return text + "\n";
}

/// A length in mm; empty if it is unknown.
std::string mm_text(const std::optional<double>& metres) {
  return metres ? fixed(1e3 * *metres, 3) : "";
}

std::string differences_text(const std::vector<Answer>& answers,
                             const std::vector<CurlDifference>& differences) {
  Table table({"MONITOR", "RUN", ">CURL mm", ">± mm", "AT", ">LESS 1 mm", ">± mm", ">LARGEST mm",
               "AT", ""});
  std::string monitor;
  for (const CurlDifference& row : differences) {
    const Answer& other = answers[row.answer];
    const auto error = [](const Answer& answer, double curl_m) {
      return mm_text(discretisation_error(answer.description, curl_m));
    };
    const std::string end = row.course.text(row.course.at.back());
    const std::string name = cut(row.monitor, widest_monitor);
    table.add({name, "1", mm_text(row.first_m), error(answers.front(), row.first_m), end});
    table.add({name, std::to_string(row.answer + 1), mm_text(row.other_m),
               error(other, row.other_m), end, signed_mm(row.end_m), mm_text(row.error_m),
               signed_mm(row.largest_m), row.course.text(row.largest_at), verdict(row)});
  }
  return table.text();
}

std::string sentences_text(const std::vector<Answer>& answers,
                           const std::vector<CurlDifference>& differences) {
  std::string text;
  for (const Explained& explained : explanations(answers, differences)) {
    const std::string run = "run " + std::to_string(explained.difference->answer + 1) + ", ";
    text += run + wrapped(explained.text, page_columns, display_width(run), 2) + "\n";
  }
  return text;
}

std::string findings_text(const std::vector<Answer>& answers) {
  std::string text;
  for (std::size_t i = 0; i < answers.size(); ++i)
    for (const v1::Finding& finding : answers[i].findings)
      text += "run " + std::to_string(i + 1) + ": " + finding_line(finding) + "\n";
  return text;
}

Json difference_json(const CurlDifference& row, const Explained& explained) {
  static constexpr const char* sources[] = {"unknown", "table", "qualities"};
  Json json{{"monitor", row.monitor},
            {"run", row.answer},
            {"compared_by", row.course.by_length ? "cast_length_m" : "time_s"},
            {"compared_at", row.course.at.back()},
            {"first_m", row.first_m},
            {"other_m", row.other_m},
            {"end_m", row.end_m},
            {"error_m", row.error_m ? Json(*row.error_m) : Json()},
            {"error_from", sources[static_cast<int>(row.error_from)]},
            {"largest_m", row.largest_m},
            {"largest_at", row.largest_at},
            {"verdict", verdict(row)},
            {"says", explained.text},
            {"causes", Json::array()}};
  for (const Cause& cause : explained.causes)
    json["causes"].push_back({{"figure", cause.figure},
                              {"says", cause.sentence},
                              {"onset", cause.onset},
                              {"share", cause.share}});
  return json;
}

}  // namespace

std::string shown_value(const std::string& value) {
  static constexpr std::string_view speed = " m/s";
  std::string text;
  for (const char* at = value.c_str(); *at != '\0';) {
    char* end = nullptr;
    double number = std::isdigit(static_cast<unsigned char>(*at)) ? std::strtod(at, &end) : 0.0;
    if (end == nullptr) {
      if (*at != '"') text += *at;
      ++at;
      continue;
    }
    at = end;
    const char* const behind = at + speed.size();
    const bool is_speed = std::string_view(at).starts_with(speed) &&
                          std::isalnum(static_cast<unsigned char>(*behind)) == 0;
    if (is_speed) number *= mm_per_min, at = behind;
    char rounded[32];
    std::snprintf(rounded, sizeof rounded, "%.6g", number);
    text += rounded + std::string(is_speed ? " mm/min" : "");
  }
  return text;
}

std::vector<std::string> monitors_of(const std::vector<Answer>& answers) {
  std::vector<std::string> names;
  for (const Answer& answer : answers)
    for (const auto& series : answer.history.monitors)
      if (std::ranges::find(names, series.name) == names.end()) names.push_back(series.name);
  return names;
}

bool has_curl(const Chart& chart) {
  constexpr double least_shown_mm = 0.005;
  return std::ranges::any_of(chart.lines, [](const ChartLine& line) {
    return std::ranges::any_of(line.y, [](double y) { return std::abs(y) >= least_shown_mm; });
  });
}

std::vector<Explained> explanations(const std::vector<Answer>& answers,
                                    const std::vector<CurlDifference>& differences) {
  std::vector<Explained> explained;
  for (const CurlDifference& row : differences) {
    const bool named = std::ranges::none_of(differences, [&](const CurlDifference& other) {
      return other.answer == row.answer && std::abs(other.end_m) > std::abs(row.end_m);
    });
    explained.push_back({&row, {}, ""});
    if (named) explained.back().causes = causes_of(answers.front(), answers[row.answer], row);
    explained.back().text = sentence(row, explained.back().causes, named);
  }
  return explained;
}

std::string comparison_text(const std::vector<Answer>& answers,
                            const std::vector<CurlDifference>& differences,
                            const Terminal& terminal) {
  std::string text = names_text(answers) + "\n" + keys_text(answers) + "\n";
  for (const std::string& monitor : monitors_of(answers))
    text += curves_text(answers, monitor, terminal);
  return text + differences_text(answers, differences) + findings_text(answers) + "\n" +
         sentences_text(answers, differences);
}

Json comparison_json(const std::vector<Answer>& answers,
                     const std::vector<CurlDifference>& differences) {
  Json json{{"runs", Json::array()}, {"keys", Json::array()}, {"differences", Json::array()}};
  for (const Answer& answer : answers) json["runs"].push_back(answer_json(answer));
  for (const KeyDifference& row : differing_keys(answers))
    json["keys"].push_back({{"key", row.key}, {"values", row.values}});
  for (const Explained& explained : explanations(answers, differences))
    json["differences"].push_back(difference_json(*explained.difference, explained));
  return json;
}

}  // namespace dccast::client::render
