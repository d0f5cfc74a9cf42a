#include "client/text/answer_text.hpp"

#include <algorithm>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

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

}  // namespace dccast::client::render
