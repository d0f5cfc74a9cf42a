#include "client/text/answer_text.hpp"

#include <algorithm>

#include "client/text/findings.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"

namespace dccast::client {
namespace {

Json monitor_json(const figures::MonitorSeries& series) {
  return {{"name", series.name},
          {"curl_m", series.curl_m},
          {"temperature_c", series.temperature_c},
          {"end_curl_m", series.curl_m.back()},
          {"end_lower_error_m", series.lower_error_m.back()},
          {"end_upper_error_m", series.upper_error_m.back()}};
}

}  // namespace

std::string answer_text(const Answer& answer) {
  std::string text;
  if (!answer.changes.empty()) text += "changed: " + changes_text(answer.changes) + "\n";
  for (const v1::Finding& finding : answer.findings) text += finding_line(finding) + "\n";
  if (answer.validity_loss) text += validity_text(*answer.validity_loss) + "\n";
  if (answer.failure)
    text += state_text(answer.state) + ": " + failure_text(*answer.failure) + "\n";
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
            {"changes", json_list(answer.changes, to_json)},
            {"findings", json_list(answer.findings, to_json)},
            {"validity_loss", answer.validity_loss ? to_json(*answer.validity_loss) : Json()},
            {"time_s", answer.history.time_s()},
            {"cast_length_m", answer.history.cast_length_m()},
            {"beyond_validity", answer.history.beyond()},
            {"monitors", Json::array()},
            {"solver_s", answer.solver_s},
            {"first_point_s", answer.first_point_s},
            {"elapsed_s", answer.elapsed_s}};

  for (const std::string& monitor : answer.history.monitors())
    json["monitors"].push_back(monitor_json(answer.history.series(monitor)));
  return json;
}

}  // namespace dccast::client
