#include "client/html/judgement_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/findings.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/plant_words.hpp"

namespace dccast::client {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return text;
}

/// Leaves every so many numbers and the last one, with six digits: what a picture shows.
void thin(Numbers& values, int stride) {
  int kept = 0;
  for (int i = 0; i < values.size();
       i = i + 1 < values.size() ? std::min(i + stride, values.size() - 1) : values.size())
    values[kept++] =
        std::isfinite(values[i]) ? std::stod(fmt::format("{:.6g}", values[i])) : values[i];
  values.Truncate(kept);
}

/// "12.3 ± 1.4", "35.5, -0 +3.9".
std::string with_error(const ShownColumn& column, std::size_t row) {
  if (!column.has_error || column.errors[row].empty()) return column.cells[row];
  const std::string& errors = column.errors[row];
  return figures::with_errors(column.cells[row], errors.starts_with('-') ? errors : "± " + errors);
}

/// @param both  bars extend to both sides of zero; otherwise zero is at the left
std::string bar_part(const Bar& bar, bool both) {
  const double zero = both ? 50.0 : 0.0;  // of 100
  const double scale = 100.0 - zero;
  return fmt::format(
      "<svg class='scale' viewBox='0 0 100 10' preserveAspectRatio='none' aria-hidden='true'>"
      "<rect x='{:.1f}' y='1' width='{:.1f}' height='8'/><path d='M{} 0v10'/></svg>",
      zero + scale * bar.low, scale * (bar.high - bar.low), zero);
}

/// A table with its heading, or a chart with its note, as it stands in a card of the dashboard.
std::string part_of_card(const v1::JudgementPart& part) {
  if (part.has_chart()) {
    const std::string& note = part.chart().note();
    return drawn("chart", chart_json(part.chart())) +
           (note.empty() ? "" : element("p class='soft'", html_escaped(note)));
  }
  const std::string heading = html_escaped(capitalised(part.table().heading()));
  return (heading.empty() ? "" : element("h3", heading)) + table_part(part.table());
}

std::string findings_list(const v1::Comparison& comparison) {
  std::string html;
  for (const auto& run : comparison.runs()) {
    const auto add = [&](const std::string& text) {
      html += element("li", html_escaped(fmt::format("{}: {}", run.name(), text)));
    };
    for (const v1::Finding& finding : run.findings()) add(finding_line(finding));
    if (run.has_validity_loss()) add(validity_text(run.validity_loss()));
  }
  return html.empty() ? "" : card("Findings", element("ul", html));
}

}  // namespace

Json chart_json(v1::Chart chart) {
  constexpr int most_points = 400;  // of a line, in a drawing 640 wide
  for (v1::Chart::Line& line : *chart.mutable_lines()) {
    const int stride = 1 + (line.x_size() - 1) / most_points;
    for (Numbers* values :
         {line.mutable_x(), line.mutable_y(), line.mutable_low(), line.mutable_high()})
      thin(*values, stride);
  }
  return to_json(chart);
}

std::string chart_figure(const v1::Chart& chart) {
  return figure(html_escaped(capitalised(chart.heading())), drawn("chart", chart_json(chart)),
                html_escaped(chart.note()));
}

const v1::Table& find_table(const v1::Judgement& judgement, const std::string& key) {
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_table() && part.table().key() == key) return part.table();
  return v1::Table::default_instance();
}

std::string table_part(const v1::Table& table) {
  const std::string note =
      table.note().empty() ? "" : element("p class='soft'", html_escaped(table.note()));
  if (table.rows().empty()) return note;

  std::string head;
  std::vector<std::string> rows(static_cast<std::size_t>(table.rows_size()));
  const auto add = [&](const std::string& kind, const std::string& heading, auto cell_of) {
    const std::string name = html_escaped(heading);
    head += element("th scope='col'" + kind, name);
    for (std::size_t row = 0; row < rows.size(); ++row)
      rows[row] += element("td data-label='" + name + "'" + kind, cell_of(row));
  };
  for (const ShownColumn& column : shown_columns(table))
    add(column.is_number ? "" : " class='text'",
        column.heading + (column.unit.empty() ? "" : ", " + column.unit),
        [&](std::size_t row) { return html_escaped(with_error(column, row)); });
  if (const auto bars = bars_of(table); !bars.empty()) {
    const bool both = std::ranges::any_of(bars, [](const Bar& bar) { return bar.low < 0.0; });
    add("", both ? "less | more" : "", [&](std::size_t row) { return bar_part(bars[row], both); });
  }

  std::string body;
  for (const std::string& row : rows) body += element("tr", row);
  return figures_table(element("tr", head), body) + note;
}

std::string table_card(const v1::Table& table, const std::string& picture) {
  return card(html_escaped(capitalised(table.heading())), picture + table_part(table));
}

std::string facts_card(const v1::Table& facts, const std::string& more) {
  std::string rows;
  for (const v1::Table::Row& fact : facts.rows())
    rows += row(html_escaped(fact.cells(0).text()), html_escaped(fact.cells(1).text()),
                html_escaped(fact.cells(2).text()));
  return rows.empty() ? ""
                      : card(html_escaped(capitalised(facts.heading())),
                             element("table class='facts'", rows) + more);
}

std::string sentences_part(const v1::Judgement& judgement) {
  std::string html;
  for (const std::string& sentence : judgement.sentences())
    html += element("p class='answer'", html_escaped(sentence));
  return html;
}

Json judgement_as_shown(const v1::Judgement& judgement) {
  Json parts = Json::array();
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.place() != v1::JudgementPart::TERMINAL)
      parts.push_back({{"key", part.has_table() ? part.table().key() : part.chart().key()},
                       {"html", part_of_card(part)}});
  Json json = to_json(judgement);
  json["parts"] = parts;
  return json;
}

std::string judgement_parts(const v1::Judgement& judgement) {
  std::string html;
  std::string charts;  // that follow each other, side by side
  const auto close_charts = [&] {
    if (!charts.empty()) html += element("div class='pair'", std::exchange(charts, {}));
  };

  for (const v1::JudgementPart& part : judgement.parts()) {
    if (part.place() == v1::JudgementPart::TERMINAL) continue;
    if (part.has_chart()) {
      charts += chart_figure(part.chart());
      continue;
    }
    close_charts();
    html += table_card(part.table());
  }
  close_charts();
  return html;
}

std::string casting_page(const v1::Case& complete) {
  const std::string title = html_escaped(complete.title());
  Json charts = Json::array();
  for (const v1::Chart& chart : case_file::planned_charts(complete))
    charts.push_back(chart_json(chart));

  return whole_page(
      title, element("h1", title),
      element("p class='answer'", html_escaped(case_file::casting_summary(complete))) +
          card("Start of the casting",
               drawn("casting", {{"case", to_json(complete)}, {"charts", charts}})));
}

std::string judgement_page(const v1::StudyJudgement& study) {
  const std::string title = html_escaped(study.study().title());
  const v1::Judgement& judgement = study.judgement();
  return whole_page(
      title,
      element("p class='kicker'", fmt::format("Study {}", html_escaped(study.study().id()))) +
          element("h1", title) + element("p class='note'", html_escaped(judgement.heading())),
      sentences_part(judgement) + judgement_parts(judgement));
}

std::string comparison_page(const v1::Comparison& comparison) {
  const v1::Judgement& judgement = comparison.judgement();
  return whole_page(
      "dccast comparison",
      "<p class='kicker'>dccast comparison</p>" + element("h1", html_escaped(judgement.heading())),
      sentences_part(judgement) + findings_list(comparison) + judgement_parts(judgement));
}

}  // namespace dccast::client
