#include <algorithm>
#include <cmath>

#include "client/html/html_parts.hpp"
#include "client/html/report_parts.hpp"
#include "client/text/job_text.hpp"
#include "client/text/study_text.hpp"
#include "proto/values/interpolation.hpp"

namespace dccast::client::render {
namespace {

constexpr std::size_t band_instants = 80;  // of a chart about 560 wide

/// One point of the band: the last of instants [from, to), with the interval of all of them.
void add_point(ChartBand& band, const CurveLimit& limit, std::size_t from, std::size_t to,
               double x) {
  double low = limit.value_m[to - 1], high = low;
  for (std::size_t i = from; i < to; ++i) {
    if (!std::isfinite(limit.value_m[i])) continue;
    low = std::min(low, limit.value_m[i] - limit.uncertainty_m[i]);
    high = std::max(high, limit.value_m[i] + limit.uncertainty_m[i]);
  }
  if (!std::isfinite(limit.value_m[to - 1])) return;
  band.x.push_back(x);
  band.middle.push_back(1e3 * limit.value_m[to - 1]);
  band.low.push_back(1e3 * low);
  band.high.push_back(1e3 * high);
}

std::string table_of(const Study& study, const v1::Job& job) {
  std::vector<std::string> headings{"refinement", "nodes", "solver, s", "state"};
  for (const std::string& name : monitor_names(study)) headings.push_back(name + ", mm");
  const auto row = [](const std::string& kind, const std::vector<std::string>& texts) {
    return element("tr class='" + kind + "'", cells(texts));
  };
  std::string rows;
  auto levels = level_rows(study);
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const bool is_this = study.levels[k].job.id() == job.id();
    if (is_this) levels[k][0] += ", this run";
    rows += row(is_this ? "this" : "", levels[k]);
  }
  // In the order of limit_rows().
  constexpr const char* names[] = {"observed order", "limit, mm", "uncertainty ±, mm",
                                   "largest ± on the way, mm", "at time, s"};
  auto limits = limit_rows(study);
  for (std::size_t k = 0; k < limits.size(); ++k) {
    limits[k][0] = names[k];
    rows += row(k == 0 ? "first" : "", limits[k]);
  }
  return figures_table(element("tr class=''", cells(headings, "th")), rows);
}

/// Levels that do not count, and why.
std::string losses(const Study& study) {
  std::string text;
  for (const StudyLevel& level : study.levels) {
    if (level.succeeded()) continue;
    text += "<p>Refinement " + std::to_string(level.refinement) + " is left out: job " +
            html_escaped(level.job.id()) + " is " + state_text(level.job.state());
    if (level.job.has_failure()) text += ", " + html_escaped(failure_text(level.job.failure()));
    text += ".</p>";
  }
  return text;
}

constexpr const char* explanation =
    "The same casting with cells and time steps divided by the refinement; curl at the end. The "
    "order is that of the whole history. The limit is extrapolated from the last three runs, with "
    "not more than first order, that of the time steps; its uncertainty is 1.25 times the distance "
    "that is left. Where runs are fewer or do not settle, the limit is the finest run and the "
    "uncertainty 1.25 times the largest difference so far. The ± beside a curl of this run is its "
    "distance to the limit and the limit's uncertainty together. Only discretisation: not the "
    "thermal data, not the material.";

std::string no_error_known(const Study& study, const v1::Job& job) {
  const std::string begin = "<p class='note'>How much of the curl is discretisation is not known: ";
  if (study.id.empty())
    return begin + "this run stands alone. <code>dccast convergence CASE</code> shows it.</p>";
  return begin + "of the runs of its study " + std::to_string(study.succeeded().size()) +
         " succeeded, two are needed. <code>dccast convergence --study " +
         html_escaped(job.study()) + "</code> shows it.</p>";
}

}  // namespace

std::optional<CurlError> curl_error(const Study& study, const std::string& monitor, double time_s,
                                    double curl_m) {
  const MonitorStudy* found = study.monitor(monitor);
  if (found == nullptr) return std::nullopt;
  CurlError error;
  error.limit_m = values::at_instants({time_s}, study.time_s, found->limit.value_m).front();
  error.uncertainty_m =
      values::at_instants({time_s}, study.time_s, found->limit.uncertainty_m).front();
  error.this_run_m = std::abs(curl_m - error.limit_m) + error.uncertainty_m;
  error.extrapolated = found->limit.order.has_value();
  if (!std::isfinite(error.this_run_m)) return std::nullopt;
  return error;
}

ChartBand curl_band(const Study& study, const std::string& monitor, bool against_length) {
  ChartBand band;
  const MonitorStudy* found = study.monitor(monitor);
  if (found == nullptr) return band;
  const std::size_t count = study.time_s.size();
  const std::size_t stride = (count + band_instants - 1) / band_instants;
  for (std::size_t from = 0; from < count; from += stride) {
    const std::size_t to = std::min(from + stride, count);
    add_point(band, found->limit, from, to,
              against_length ? 1e3 * study.cast_length_m[to - 1] : study.time_s[to - 1]);
  }
  return band;
}

std::string study_part(const Study& study, const v1::Job& job) {
  if (study.monitors.empty()) return no_error_known(study, job);
  const std::string note = validity_note(study);
  return card("How much of it is discretisation",
              table_of(study, job) + losses(study) +
                  (note.empty() ? "" : "<p><strong>" + html_escaped(note) + ".</strong></p>") +
                  element("p", explanation));
}

}  // namespace dccast::client::render
