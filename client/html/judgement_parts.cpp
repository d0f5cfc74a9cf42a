#include "client/html/judgement_parts.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/findings.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/table.hpp"
#include "proto/values/plant_units.hpp"

namespace dccast::client::render {
namespace {

std::vector<double> scaled(const google::protobuf::RepeatedField<double>& values, double factor) {
  std::vector<double> shown;
  for (const double value : values) shown.push_back(factor * value);
  return shown;
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
std::string bar_svg(const Bar& bar, bool both) {
  constexpr double width = 120.0;
  const double zero = both ? 0.5 * width : 0.0;
  const double scale = width - zero;
  return fmt::format(
      "<svg viewBox='0 0 {0:.0f} 10' style='width:{0:.0f}px' aria-hidden='true'>"
      "<rect x='{1:.1f}' y='1' width='{2:.1f}' height='8' style='fill:var(--line-0)'/>"
      "<line class='zero' x1='{3:.0f}' x2='{3:.0f}' y1='0' y2='10'/></svg>",
      width, zero + scale * bar.low, scale * (bar.high - bar.low), zero);
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

Chart chart_of(const v1::Chart& chart) {
  const double x_factor = values::plant_unit(chart.x().unit()).factor;
  const double y_factor = values::plant_unit(chart.y().unit()).factor;
  Chart shown{chart.heading(), axis_label(chart.x()), axis_label(chart.y()), {}};
  for (const v1::Chart::Line& line : chart.lines()) {
    ChartLine& drawn = shown.lines.emplace_back();
    drawn.name = line.name();
    drawn.dots = line.is_dotted();
    drawn.x = scaled(line.x(), x_factor);
    drawn.y = scaled(line.y(), y_factor);
    if (!line.low().empty())
      drawn.band = {drawn.x, drawn.y, scaled(line.low(), y_factor), scaled(line.high(), y_factor)};
  }

  if (chart.has_region())
    shown.wanted = Chart::Wanted{y_factor * chart.region().low(), y_factor * chart.region().high(),
                                 chart.region().name()};
  if (chart.has_beyond_x()) {
    shown.beyond_from = x_factor * chart.beyond_x();
    shown.beyond_name = beyond_validity;
  }
  return shown;
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
    add("", both ? "less | more" : "", [&](std::size_t row) { return bar_svg(bars[row], both); });
  }

  std::string body;
  for (const std::string& row : rows) body += element("tr", row);
  return figures_table(element("tr", head), body) + note;
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
      charts += card(capitalised(part.chart().heading()), svg_chart(chart_of(part.chart())));
      continue;
    }
    close_charts();
    html += card(capitalised(part.table().heading()), table_part(part.table()));
  }
  close_charts();
  return html;
}

std::string svg_file(const Chart& chart) {
  const std::string svg = svg_chart(chart);
  const std::string begin = "<svg ";
  const std::string end = "</svg>";
  const auto head = svg.find('>');
  return svg_file(svg.substr(begin.size(), head - begin.size()),
                  svg.substr(head + 1, svg.size() - end.size() - head - 1));
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
