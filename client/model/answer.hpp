#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// Curl of every monitor against time and cast length. Curl is the vertical displacement.
struct CurlHistory {
  /// The curl of one monitor over the steps.
  struct Series {
    std::string name;
    std::vector<double> curl_m{};  ///< [m] one per time; NaN where the monitor is not reported
    /// How far mesh and time steps may have put the true curl below and above [m]; NaN: not known.
    std::vector<double> lower_error_m{}, upper_error_m{};
    /// Horizontal displacement [m] by time: away from the symmetry plane in a section, its x and y
    /// component in a quarter slab; NaN where the monitor is not reported.
    std::vector<std::vector<double>> horizontal_m{};
    std::vector<double> temperature_c{};  ///< [°C]; NaN until metal reaches the monitor
    /// Whether the error of the last curl is known.
    bool has_error() const { return !upper_error_m.empty() && std::isfinite(upper_error_m.back()); }
  };
  std::vector<std::int64_t> step;  ///< number of the accepted step, ascending; 0 if unknown
  std::vector<double> time_s;
  /// (step) cast length [m].
  std::vector<double> cast_length_m;
  std::vector<bool> beyond;  ///< the model was no longer valid at this time
  std::vector<Series> monitors;
  std::vector<v1::StepReport> reports;  ///< by time

  /// Adds a step. A step that is already present replaces itself and all later ones: the run was
  /// resumed.
  void add(const v1::StepReport& report);
  /// Removes the steps after this one, from which the run continues. 0: the run starts again.
  void rewind(std::int64_t last_step);
  /// Marks this time [s] and all later ones as beyond validity.
  void mark_beyond(double time_s);
  /// Index of the first time beyond validity; empty if all are valid.
  std::optional<std::size_t> first_beyond() const;
  /// The monitor with the largest present curl; null before the first step.
  const Series* largest() const;
};

/// The history of a job as QueryResult has it, marked from the job's loss of validity on.
CurlHistory curl_history(const v1::Job& job, const v1::QueryResultResponse& result);

/// Curl of a monitor [m]; NaN where it has none.
double curl_of(const v1::MonitorValue& monitor);

/// Answer of a query or result of a job: a case with its curl.
struct Answer {
  std::string name;         ///< name of the file or job, for tables
  std::string job;          ///< id of the job; empty if it is not stored
  std::string key;          ///< names the answer to the server where there is no job
  bool from_store = false;  ///< no solver ran
  v1::Case description;     ///< complete
  std::vector<v1::CaseChange> changes;
  /// Curves, findings and end of a run, as far as it has come.
  CurlHistory history;
  std::vector<v1::Finding> findings;
  std::optional<v1::Finding> validity_loss;
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<v1::Finding> failure;
  double solver_s = 0.0;
  double first_point_s = 0.0;  ///< from the call to the first step, measured by the client [s]
  double elapsed_s = 0.0;      ///< from the call to its end [s]
};

/// What a curl tends to as cells and time steps go to zero, by a refinement study.
struct CurlLimit {
  std::vector<double> value_m;        ///< (instant) [m]; NaN outside the time of the study
  std::vector<double> uncertainty_m;  ///< (instant) half width of the interval around it [m]
  bool extrapolated = false;          ///< else the value is that of the finest run
};
/// @return empty if the study has no limit of this monitor
std::optional<CurlLimit> limit_at(const std::vector<double>& instants_s,
                                  const v1::StudyResult& study, const std::string& monitor);

/// The changes given by the user as KEY=VALUE, in order.
std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts);

/// "schedule.hold = 5 s, mesh.rows = 30"; empty for none.
template <class Changes>
std::string changes_text(const Changes& changes) {
  std::string text;
  for (const v1::CaseChange& change : changes)
    text += (text.empty() ? "" : ", ") + change.key() + " = " + change.value();
  return text;
}

}  // namespace dccast::client
