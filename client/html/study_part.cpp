#include <algorithm>
#include <cmath>

#include <fmt/core.h>

#include "client/html/html_parts.hpp"
#include "client/html/judgement_parts.hpp"
#include "client/html/report_parts.hpp"

namespace dccast::client::render {
namespace {

constexpr int band_instants = 80;  // of a chart about 560 wide

/// A point of the band: the last of the instants [from, to), with the interval of all of them.
void add_point(ChartBand& band, const v1::CurlCurve& curve, int from, int to, double x) {
  const double middle = curve.curl_m(to - 1);
  if (!std::isfinite(middle)) return;

  double low = middle, high = middle;
  for (int i = from; i < to; ++i) {
    if (!std::isfinite(curve.curl_m(i))) continue;
    low = std::min(low, curve.curl_m(i) - curve.uncertainty_m(i));
    high = std::max(high, curve.curl_m(i) + curve.uncertainty_m(i));
  }
  band.x.push_back(x);
  band.middle.push_back(1e3 * middle);
  band.low.push_back(1e3 * low);
  band.high.push_back(1e3 * high);
}

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

ChartBand curl_band(const v1::StudyResult& study, const std::string& monitor, bool against_length) {
  ChartBand band;
  for (const v1::StudyResult::Limit& limit : study.limits()) {
    const v1::CurlCurve& curve = limit.curve();
    if (curve.monitor() != monitor) continue;

    const int count = curve.time_s_size();
    const int stride = (count + band_instants - 1) / band_instants;
    for (int from = 0; from < count; from += stride) {
      const int to = std::min(from + stride, count);
      add_point(band, curve, from, to,
                against_length ? 1e3 * curve.cast_length_m(to - 1) : curve.time_s(to - 1));
    }
  }
  return band;
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
