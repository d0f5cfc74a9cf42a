#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/report_parts.hpp"

namespace dccast::client::render {
namespace {

constexpr const char* explanation =
    "The same casting with cells and time steps divided by the refinement; curl at the end. The "
    "order is that of the whole history. The limit is extrapolated from the last three runs, with "
    "not more than first order, that of the time steps; its uncertainty is 1.25 times the distance "
    "that is left. Where runs are fewer or do not settle, the limit is the finest run and the "
    "uncertainty 1.25 times the largest difference so far. The ± beside a curl of this run is its "
    "distance to the limit and the limit's uncertainty together. Only discretisation: not the "
    "thermal data, not the material.";

std::string no_error_known(const v1::StudyResult& result, const v1::Job& job) {
  const std::string begin = "<p class='note'>How much of the curl is discretisation is not known: ";
  if (result.runs().empty())
    return begin + "this run stands alone. <code>dccast convergence CASE</code> shows it.</p>";

  const auto succeeded = std::ranges::count(result.runs(), v1::SUCCEEDED, &v1::StudyRun::state);
  return fmt::format(
      "{}of the runs of its study {} succeeded, two are needed. <code>dccast convergence --study "
      "{}</code> shows it.</p>",
      begin, succeeded, html_escaped(job.study()));
}

/// The level that the report is about.
std::string level_note(const v1::StudyResult& result, const v1::Job& job) {
  const auto level = std::ranges::find(result.runs(), job.id(), &v1::StudyRun::job);
  if (level == result.runs().end()) return {};
  return element("p", fmt::format("This run has refinement {}.", level->refinement()));
}

}  // namespace

std::optional<CurlError> curl_error(const v1::StudyResult& study, const std::string& monitor,
                                    double time_s, double curl_m) {
  const auto limit = limit_at({time_s}, study, monitor);
  if (!limit) return std::nullopt;

  CurlError error;
  error.limit_m = limit->value_m.front();
  error.uncertainty_m = limit->uncertainty_m.front();
  error.this_run_m = std::abs(curl_m - error.limit_m) + error.uncertainty_m;
  error.extrapolated = limit->extrapolated;
  if (!std::isfinite(error.this_run_m)) return std::nullopt;
  return error;
}

void add_limits(v1::Chart& chart, const v1::StudyResult& study, bool against_length) {
  for (const v1::StudyResult::Limit& limit : study.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    v1::Chart::Line& line = add_line(chart, curve.monitor() + ", limit of finer meshes");
    for (int i = 0; i < curve.time_s_size(); ++i) {
      add_point(line, against_length ? curve.cast_length_m(i) : curve.time_s(i), curve.curl_m(i));
      line.add_low(curve.curl_m(i) - curve.uncertainty_m(i));
      line.add_high(curve.curl_m(i) + curve.uncertainty_m(i));
    }
  }
}

std::string study_part(const v1::StudyJudgement& study, const v1::Job& job) {
  if (study.result().limits().empty()) return no_error_known(study.result(), job);

  // The charts of the report already show the limits.
  std::string html;
  for (const std::string& sentence : study.judgement().sentences())
    html += element("p", html_escaped(sentence));
  for (const v1::JudgementPart& part : study.judgement().parts())
    if (part.has_table()) html += table_part(part.table());
  return card("How much of it is discretisation",
              level_note(study.result(), job) + html + element("p", explanation));
}

}  // namespace dccast::client::render
