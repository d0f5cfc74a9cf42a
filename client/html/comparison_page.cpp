#include <algorithm>
#include <cmath>

#include "client/html/report_style.hpp"
#include "client/model/answer.hpp"
#include "client/text/answer_text.hpp"
#include "client/text/comparison_text.hpp"
#include "client/text/findings.hpp"
#include "client/text/table.hpp"

namespace dccast::client::render {
namespace {

std::string cell(const std::string& text, const char* element = "td") {
  return std::string("<") + element + ">" + html_escaped(text) + "</" + element + ">";
}

std::string card(const std::string& heading, const std::string& content) {
  return "<section class='card'><h2>" + html_escaped(heading) + "</h2>" + content + "</section>";
}

std::string run_name(const std::vector<Answer>& answers, std::size_t i) {
  return std::to_string(i + 1) + " " + answers[i].name;
}

std::string keys_table(const std::vector<Answer>& answers) {
  const auto keys = differing_keys(answers);
  if (keys.empty()) return "<p>The cases do not differ.</p>";
  std::string html = "<div class='scroll'><table><tr>" + cell("key", "th");
  for (std::size_t i = 0; i < answers.size(); ++i) html += cell(run_name(answers, i), "th");
  for (const KeyDifference& row : keys) {
    html += "</tr><tr>" + cell(row.key);
    for (const std::string& value : row.values) html += cell(shown_value(value));
  }
  return html + "</tr></table></div>";
}

std::string differences_table(const std::vector<Answer>& answers,
                              const std::vector<CurlDifference>& differences) {
  std::string html = "<div class='scroll'><table><tr>" + cell("monitor", "th") + cell("run", "th") +
                     cell("less run 1", "th") + cell("at", "th") + cell("largest", "th") +
                     cell("verdict", "th");
  for (const CurlDifference& row : differences)
    html += "</tr><tr>" + cell(row.monitor) + cell(run_name(answers, row.answer)) +
            cell(fixed(1e3 * row.end_m, 3) +
                 (row.error_m ? " ± " + fixed(1e3 * *row.error_m, 3) : "") + " mm") +
            cell(row.course.text(row.course.at.back())) +
            cell(fixed(1e3 * row.largest_m, 3) + " mm at " + row.course.text(row.largest_at)) +
            cell(verdict(row));
  return html + "</tr></table></div>";
}

std::string sentences_list(const std::vector<Answer>& answers,
                           const std::vector<Explained>& explained) {
  std::string html;
  for (const Explained& row : explained)
    html += "<li>" + html_escaped(run_name(answers, row.difference->answer) + ", " + row.text) +
            "</li>";
  return html.empty() ? "" : card("What changed", "<ul>" + html + "</ul>");
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
  return card(chart.title, svg_chart(chart));
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
      html += card(cause.sentence,
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
  for (std::size_t i = 0; i < answers.size(); ++i) {
    for (const v1::Finding& finding : answers[i].findings)
      html += "<li>" + html_escaped(run_name(answers, i) + ": " + finding_line(finding)) + "</li>";
    if (answers[i].validity_loss)
      html += "<li>" +
              html_escaped(run_name(answers, i) + ": " + validity_text(*answers[i].validity_loss)) +
              "</li>";
  }
  return html.empty() ? "" : card("Findings", "<ul>" + html + "</ul>");
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
  std::string svg = svg_chart(chart);
  const std::string begin = "<svg ";
  return "<?xml version='1.0' encoding='UTF-8'?>\n<svg xmlns='http://www.w3.org/2000/svg' " +
         svg.substr(begin.size(), svg.find('>') + 1 - begin.size()) + "<style>" + report_style +
         "</style>" + svg.substr(svg.find('>') + 1) + "\n";
}

std::string comparison_page(const std::vector<Answer>& answers,
                            const std::vector<CurlDifference>& differences) {
  std::string charts;
  for (const std::string& monitor : monitors_of(answers))
    if (const Chart chart = comparison_chart(answers, monitor); has_curl(chart))
      charts += card("Curl of " + monitor, svg_chart(chart));
  for (const std::string& monitor : monitors_of(answers))
    charts += difference_chart(answers, differences, monitor);
  const std::vector<Explained> explained = explanations(answers, differences);
  return std::string(
             "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' ") +
         "content='width=device-width,initial-scale=1'><title>dccast comparison</title><style>" +
         report_style + "</style></head><body><main><header><p class='kicker'>dccast " +
         "comparison</p><h1>" + std::to_string(answers.size()) + " runs</h1></header>" +
         sentences_list(answers, explained) + findings_list(answers) +
         card("What differs in the cases", keys_table(answers)) + charts +
         card("Differences of the curl", differences_table(answers, differences)) +
         cause_charts(answers, explained) + "</main></body></html>\n";
}

}  // namespace dccast::client::render
