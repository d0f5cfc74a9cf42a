#include <algorithm>
#include <cmath>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/model/answer.hpp"
#include "client/text/comparison_text.hpp"
#include "client/text/findings.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

std::string run_name(const std::vector<Answer>& answers, std::size_t i) {
  return std::to_string(i + 1) + " " + answers[i].name;
}

/// @param rows  cells of each, the first one those of the headings
std::string plain_table(const std::vector<std::string>& rows) {
  std::string html;
  for (const std::string& row : rows) html += element("tr", row);
  return "<div class='scroll'>" + element("table", html) + "</div>";
}

std::string keys_table(const std::vector<Answer>& answers) {
  const auto keys = differing_keys(answers);
  if (keys.empty()) return "<p>The cases do not differ.</p>";
  std::vector<std::string> headings{"key"};
  for (std::size_t i = 0; i < answers.size(); ++i) headings.push_back(run_name(answers, i));
  std::vector<std::string> rows{cells(headings, "th")};
  for (const KeyDifference& row : keys) {
    std::vector<std::string> texts{row.key};
    std::ranges::transform(row.values, std::back_inserter(texts), shown_value);
    rows.push_back(cells(texts));
  }
  return plain_table(rows);
}

std::string differences_table(const std::vector<Answer>& answers,
                              const std::vector<CurlDifference>& differences) {
  std::vector<std::string> rows{
      cells({"monitor", "run", "less run 1", "at", "largest", "verdict"}, "th")};
  for (const CurlDifference& row : differences)
    rows.push_back(
        cells({row.monitor, run_name(answers, row.answer),
               mm(row.end_m, 3) + (row.error_m ? " ± " + mm(*row.error_m, 3) : "") + " mm",
               row.course.text(row.course.at.back()),
               mm(row.largest_m, 3) + " mm at " + row.course.text(row.largest_at), verdict(row)}));
  return plain_table(rows);
}

std::string sentences_list(const std::vector<Answer>& answers,
                           const std::vector<Explained>& explained) {
  std::string html;
  for (const Explained& row : explained)
    html +=
        element("li", html_escaped(run_name(answers, row.difference->answer) + ", " + row.text));
  return html.empty() ? "" : card("What changed", element("ul", html));
}

/// The differences of a monitor along their courses, over the size that would be within the error.
/// Their axis is that of the differences: beside whole curls an effect of a millimetre is not seen.
std::string difference_chart(const std::vector<Answer>& answers,
                             const std::vector<CurlDifference>& differences,
                             const std::string& monitor) {
  Chart chart{"Differences of " + monitor, "time, s", "less run 1, mm", {}};
  double error_mm = 0.0;
  for (const CurlDifference& row : differences) {
    if (row.monitor != monitor || row.none()) continue;
    ChartLine line{run_name(answers, row.answer), row.course.at, row.apart_m};
    if (row.course.by_length) {
      chart.x_label = "cast length, mm";
      for (double& at : line.x) at *= 1e3;
    }
    for (double& value : line.y) value *= 1e3;
    error_mm = std::max(error_mm, 1e3 * row.error_m.value_or(0.0));
    chart.lines.push_back(std::move(line));
  }
  if (chart.lines.empty()) return {};
  if (error_mm > 0.0)
    chart.wanted =
        Chart::Wanted{-error_mm, error_mm, "within the error of a difference at the end"};
  return card(html_escaped(chart.title), svg_chart(chart));
}

/// The figures that differed before the curl, in both runs.
std::string cause_charts(const std::vector<Answer>& answers,
                         const std::vector<Explained>& explained) {
  std::string html;
  for (const Explained& row : explained) {
    const Course& course = row.difference->course;
    std::vector<double> place = course.at;
    if (course.by_length)
      for (double& at : place) at *= 1e3;
    for (const Cause& cause : row.causes)
      html += card(html_escaped(cause.sentence),
                   svg_chart({cause.figure,
                              course.by_length ? "cast length, mm" : "time, s",
                              cause.figure + ", " + cause.unit,
                              {{run_name(answers, 0), place, cause.first},
                               {run_name(answers, row.difference->answer), place, cause.other}}}));
  }
  return html;
}

std::string findings_list(const std::vector<Answer>& answers) {
  std::string html;
  const auto add = [&](std::size_t run, const std::string& text) {
    html += element("li", html_escaped(run_name(answers, run) + ": " + text));
  };
  for (std::size_t i = 0; i < answers.size(); ++i) {
    for (const v1::Finding& finding : answers[i].findings) add(i, finding_line(finding));
    if (answers[i].validity_loss) add(i, validity_text(*answers[i].validity_loss));
  }
  return html.empty() ? "" : card("Findings", element("ul", html));
}

}  // namespace

Chart comparison_chart(const std::vector<Answer>& answers, const std::string& monitor) {
  Chart chart{"Butt curl of " + monitor, "time, s", "curl, mm", {}};
  for (std::size_t i = 0; i < answers.size(); ++i)
    for (const auto& series : answers[i].history.monitors) {
      if (series.name != monitor) continue;
      ChartLine line{run_name(answers, i), answers[i].history.time_s, series.curl_m};
      for (double& value : line.y) value *= 1e3;
      if (const auto share = discretisation_error(answers[i].description, 1.0))
        line.band = band_around(line, *share);
      chart.lines.push_back(std::move(line));
    }
  return chart;
}

std::string svg_file(const Chart& chart) {
  const std::string svg = svg_chart(chart), begin = "<svg ", end = "</svg>";
  const auto head = svg.find('>');
  return svg_file(svg.substr(begin.size(), head - begin.size()),
                  svg.substr(head + 1, svg.size() - end.size() - head - 1));
}

std::string comparison_page(const std::vector<Answer>& answers,
                            const std::vector<CurlDifference>& differences) {
  std::string charts;
  for (const std::string& monitor : monitors_of(answers))
    if (const Chart chart = comparison_chart(answers, monitor); has_curl(chart))
      charts += card("Curl of " + html_escaped(monitor), svg_chart(chart));
  for (const std::string& monitor : monitors_of(answers))
    charts += difference_chart(answers, differences, monitor);
  const std::vector<Explained> explained = explanations(answers, differences);
  return whole_page("dccast comparison",
                    "<p class='kicker'>dccast comparison</p>" +
                        element("h1", std::to_string(answers.size()) + " runs"),
                    sentences_list(answers, explained) + findings_list(answers) +
                        card("What differs in the cases", keys_table(answers)) + charts +
                        card("Differences of the curl", differences_table(answers, differences)) +
                        cause_charts(answers, explained));
}

}  // namespace dccast::client::render
