#include "client/html/judgement_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <utility>
#include <vector>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/findings.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

using Numbers = google::protobuf::RepeatedField<double>;

/// Every so many numbers and the last one, with six digits: what a picture shows.
Json thinned(const Numbers& values, int stride) {
  Json shown = Json::array();
  const int last = values.size() - 1;
  const auto add = [&](double value) {
    shown.push_back(std::isfinite(value) ? std::stod(fmt::format("{:.6g}", value)) : value);
  };
  for (int i = 0; i < last; i += stride) add(values[i]);
  if (last >= 0) add(values[last]);
  return shown;
}

Json chart_json(const v1::Chart& chart) {
  constexpr int most_points = 400;  // of a line, in a drawing 640 wide
  Json json = to_json(chart);
  Json lines = Json::array();
  for (const v1::Chart::Line& line : chart.lines()) {
    const int stride = (line.x_size() + most_points - 1) / most_points;
    lines.push_back({{"name", line.name()},
                     {"x", thinned(line.x(), stride)},
                     {"y", thinned(line.y(), stride)},
                     {"low", thinned(line.low(), stride)},
                     {"high", thinned(line.high(), stride)},
                     {"is_dotted", line.is_dotted()}});
  }
  json["lines"] = lines;
  return json;
}

std::string capitalised(std::string text) {
  if (!text.empty()) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  return html_escaped(text);
}

/// "12.3 ± 1.4", "35.5, -0.0 +3.9".
std::string with_error(const std::string& value, const std::string& error) {
  if (error.empty()) return value;
  return value + (error.starts_with('-') ? ", " : " ± ") + error;
}

/// @param both  bars extend to both sides of zero; otherwise zero is at the left
std::string bar_part(const Bar& bar, bool both) {
  const double zero = both ? 50.0 : 0.0;  // [%] of the width
  const double scale = 100.0 - zero;
  return fmt::format(
      "<span class='scale{}' aria-hidden='true'><span style='left:{:.1f}%;"
      "width:{:.1f}%'></span></span>",
      both ? " both" : "", zero + scale * bar.low, scale * (bar.high - bar.low));
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

std::string chart_figure(const v1::Chart& chart) {
  return figure(capitalised(chart.heading()), drawn("chart", chart_json(chart)),
                html_escaped(chart.note()));
}

const v1::Table& find_table(const v1::Judgement& judgement, const std::string& key) {
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.has_table() && part.table().key() == key) return part.table();
  return v1::Table::default_instance();
}

std::string table_part(const v1::Table& table) {
  const std::string note = table.note().empty() ? "" : element("p", html_escaped(table.note()));
  if (table.rows().empty()) return note;

  std::string head;
  std::vector<std::string> rows(static_cast<std::size_t>(table.rows_size()));
  const auto add = [&](const std::string& kind, const std::string& heading, auto cell_of) {
    head += element("th" + kind, html_escaped(heading));
    for (std::size_t row = 0; row < rows.size(); ++row)
      rows[row] += element("td" + kind, cell_of(row));
  };
  for (const ShownColumn& column : shown_columns(table))
    add(column.is_number ? "" : " class='text'",
        column.heading + (column.unit.empty() ? "" : ", " + column.unit), [&](std::size_t row) {
          return html_escaped(
              with_error(column.cells[row], column.has_error ? column.errors[row] : ""));
        });
  if (const auto bars = bars_of(table); !bars.empty()) {
    const bool both = std::ranges::any_of(bars, [](const Bar& bar) { return bar.low < 0.0; });
    add("", both ? "less | more" : "", [&](std::size_t row) { return bar_part(bars[row], both); });
  }

  std::string body;
  for (const std::string& row : rows) body += element("tr", row);
  return figures_table(element("tr", head), body) + note;
}

std::string table_card(const v1::Table& table, const std::string& picture) {
  return card(capitalised(table.heading()), picture + table_part(table));
}

std::string facts_card(const v1::Table& facts, const std::string& more) {
  std::string rows;
  for (const v1::Table::Row& fact : facts.rows())
    rows += row(html_escaped(fact.cells(0).text()), html_escaped(fact.cells(1).text()),
                html_escaped(fact.cells(2).text()));
  return rows.empty() ? "" : card(capitalised(facts.heading()), element("table", rows) + more);
}

std::string sentences_part(const v1::Judgement& judgement) {
  std::string html;
  for (const std::string& sentence : judgement.sentences())
    html += element("p class='answer'", html_escaped(sentence));
  return html;
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

}  // namespace dccast::client::render
