#include "client/text/comparison_text.hpp"

#include <algorithm>
#include <array>
#include <cctype>
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

namespace dccast::client::render {
namespace {

// ANSI foreground colours of the lines, in the order of the answers.
constexpr std::array line_colours{34, 33, 32, 35, 36, 31};

std::string coloured(const std::string& text, std::size_t line, const Terminal& terminal) {
  if (!terminal.colour) return text;
  return "\033[" + std::to_string(line_colours[line % line_colours.size()]) + "m" + text +
         "\033[0m";
}

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

std::string keys_text(const std::vector<Answer>& answers) {
  const auto keys = differing_keys(answers);
  if (keys.empty()) return "the cases do not differ\n";
  std::vector<std::string> headings{"KEY"};
  for (std::size_t i = 0; i < answers.size(); ++i) headings.push_back(std::to_string(i + 1));
  Table table(headings);
  for (const KeyDifference& row : keys) {
    std::vector<std::string> cells{row.key};
    for (const std::string& value : row.values) cells.push_back(shown_value(value));
    table.add(std::move(cells));
  }
  return table.text();
}

std::string curves_text(const std::vector<Answer>& answers, const std::string& monitor,
                        const Terminal& terminal) {
  std::vector<BrailleLine> lines;
  std::string legend;
  const Chart chart = comparison_chart(answers, monitor);
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
  return text;
}

/// What mesh and steps leave uncertain of a curl; empty where that is not known.
std::string error_text(const Answer& answer, double curl_m) {
  const auto error_m = discretisation_error(answer.description, curl_m);
  return error_m ? fixed(1e3 * *error_m, 3) : "";
}

std::string weights_text(const std::vector<Answer>& answers) {
  Table table({"MONITOR", "RUN", ">CURL mm", ">± mm", ">LESS 1 mm", ">LARGEST mm", ">AT s", ""});
  for (const std::string& monitor : monitors_of(answers)) {
    for (const auto& series : answers.front().history.monitors)
      if (series.name == monitor && !series.curl_m.empty())
        table.add({monitor, "1", fixed(1e3 * series.curl_m.back(), 3),
                   error_text(answers.front(), series.curl_m.back()), "", "", "", ""});
    for (const CurlDifference& row : curl_differences(answers)) {
      if (row.monitor != monitor) continue;
      const auto& theirs = answers[row.answer].history.monitors;
      const auto found = std::ranges::find(theirs, monitor, &CurlHistory::Series::name);
      const double curl_m = found->curl_m.back();
      table.add({monitor, std::to_string(row.answer + 1), fixed(1e3 * curl_m, 3),
                 error_text(answers[row.answer], curl_m), signed_mm(row.end_m),
                 signed_mm(row.largest_m), fixed(row.largest_time_s, 1), in_words(weight_of(row))});
    }
  }
  return table.text();
}

std::string findings_text(const std::vector<Answer>& answers) {
  std::string text;
  for (std::size_t i = 0; i < answers.size(); ++i)
    for (const v1::Finding& finding : answers[i].findings)
      text += "run " + std::to_string(i + 1) + ": " + finding_line(finding) + "\n";
  return text;
}

Json difference_json(const CurlDifference& row) {
  const auto number = [](const std::optional<double>& value) {
    return value ? Json(*value) : Json();
  };
  return {{"monitor", row.monitor},
          {"run", row.answer},
          {"end_m", row.end_m},
          {"largest_m", row.largest_m},
          {"largest_time_s", row.largest_time_s},
          {"uncertainty_m", number(row.uncertainty_m)},
          {"first_uncertainty_m", number(row.first_uncertainty_m)},
          {"says", in_words(weight_of(row))}};
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

std::string comparison_text(const std::vector<Answer>& answers, const Terminal& terminal) {
  std::string text = names_text(answers) + "\n" + keys_text(answers) + "\n";
  for (const std::string& monitor : monitors_of(answers))
    text += curves_text(answers, monitor, terminal) + "\n";
  return text + weights_text(answers) + findings_text(answers);
}

Json comparison_json(const std::vector<Answer>& answers) {
  Json json{{"runs", Json::array()}, {"keys", Json::array()}, {"differences", Json::array()}};
  for (const Answer& answer : answers) json["runs"].push_back(answer_json(answer));
  for (const KeyDifference& row : differing_keys(answers))
    json["keys"].push_back({{"key", row.key}, {"values", row.values}});
  for (const CurlDifference& row : curl_differences(answers))
    json["differences"].push_back(difference_json(row));
  return json;
}

}  // namespace dccast::client::render
