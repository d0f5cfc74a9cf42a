#include "client/text/comparison_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include <fmt/core.h>

#include "client/model/answer.hpp"
#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client::render {
namespace {

/// "4.86 ± 0.36 mm"; without an uncertainty only the first number.
std::string curl_text(double curl_m, std::optional<double> uncertainty_m) {
  const int decimals = mm_decimals(curl_m, uncertainty_m);
  if (!uncertainty_m) return mm(curl_m, decimals) + " mm";
  return mm(curl_m, decimals) + " \u00b1 " + mm(*uncertainty_m, decimals) + " mm";
}

std::string monitor_line(const Answer& answer, const CurlHistory::Series& series) {
  const double curl_m = series.curl_m.back();
  const CurlHistory& history = answer.history;
  return series.name + ": curl " +
         curl_text(curl_m, discretisation_error(answer.description, curl_m)) + " at " +
         fixed(history.time_s.back(), 1) + " s, cast length " +
         mm(history.cast_length_m.back(), 1) + " mm" +
         (history.beyond.back() ? std::string(", ") + beyond_validity : "") + "\n";
}

Json monitor_json(const Answer& answer, const CurlHistory::Series& series) {
  const double curl_m = series.curl_m.back();
  const auto uncertainty_m = discretisation_error(answer.description, curl_m);
  return {{"name", series.name},
          {"curl_m", series.curl_m},
          {"temperature_c", series.temperature_c},
          {"end_curl_m", curl_m},
          {"uncertainty_m", uncertainty_m}};
}

template <class Messages>
Json list_json(const Messages& messages) {
  Json list = Json::array();
  for (const auto& message : messages) list.push_back(to_json(message));
  return list;
}

}  // namespace

std::string answer_text(const Answer& answer) {
  std::string text;
  if (!answer.changes.empty()) text += "changed: " + changes_text(answer.changes) + "\n";
  for (const v1::Finding& finding : answer.findings) text += finding_line(finding) + "\n";
  if (answer.validity_loss) text += validity_text(*answer.validity_loss) + "\n";
  if (answer.failure)
    text += state_text(answer.state) + ": " + failure_text(*answer.failure) + "\n";
  for (const auto& series : answer.history.monitors) text += monitor_line(answer, series);
  return text;
}

std::string waiting_text(const v1::QueryButtCurlResponse::Waiting& waiting) {
  return waiting.reason() + ", about " + duration_text(std::max(1.0, waiting.expected_s()));
}

std::string origin_text(const Answer& answer) {
  if (answer.from_store)
    return (answer.job.empty() ? std::string("computed before by a query")
                               : "computed before, job " + answer.job) +
           "; answered in " + fixed(1e3 * answer.elapsed_s, 0) + " ms";
  return "computed in " + fixed(answer.elapsed_s, 2) + " s (solver " + fixed(answer.solver_s, 2) +
         " s, first point after " + fixed(1e3 * answer.first_point_s, 0) + " ms)" +
         (answer.job.empty() ? "" : "; stored as job " + answer.job);
}

Json answer_json(const Answer& answer) {
  Json json{{"name", answer.name},
            {"job", answer.job.empty() ? Json() : Json(answer.job)},
            {"from_store", answer.from_store},
            {"state", v1::JobState_Name(answer.state)},
            {"failure", answer.failure ? to_json(*answer.failure) : Json()},
            {"changes", list_json(answer.changes)},
            {"findings", list_json(answer.findings)},
            {"validity_loss", answer.validity_loss ? to_json(*answer.validity_loss) : Json()},
            {"time_s", answer.history.time_s},
            {"cast_length_m", answer.history.cast_length_m},
            {"beyond_validity", answer.history.beyond},
            {"monitors", Json::array()},
            {"solver_s", answer.solver_s},
            {"first_point_s", answer.first_point_s},
            {"elapsed_s", answer.elapsed_s}};
  for (const auto& series : answer.history.monitors)
    json["monitors"].push_back(monitor_json(answer, series));
  return json;
}

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
  return (metres >= 0.0 ? "+" : "") + mm(metres, 3);
}

std::string names_text(const std::vector<Answer>& answers) {
  std::string text;
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const std::string& title = answers[i].description.title();
    text += fmt::format("{}  {}{}{}\n", i + 1, answers[i].name, title.empty() ? "" : "  ", title);
    if (!answers[i].changes.empty()) text += "   " + changes_text(answers[i].changes) + "\n";
  }
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
    legend +=
        (i == 0 ? "" : "  ") + coloured(braille_sample(i) + " " + chart.lines[i].name, i, terminal);
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
  return metres ? mm(*metres, 3) : "";
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
            {"error_m", row.error_m},
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
    text += fmt::format("{:.6g}{}", number, is_speed ? " mm/min" : "");
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
