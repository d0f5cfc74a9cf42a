#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"

namespace dccast::client {

/// Curl of every monitor against time and cast length. Curl is the vertical displacement.
struct CurlHistory {
  struct Series {
    std::string name;
    std::vector<double> curl_m;  ///< [m] one per time; NaN where the monitor is not reported
    /// Horizontal displacement [m] by time: away from the symmetry plane in a section, its x and y
    /// component in a quarter slab; NaN where the monitor is not reported.
    std::vector<std::vector<double>> horizontal_m;
    std::vector<double> temperature_c;  ///< [°C]; NaN until metal reaches the monitor
  };
  std::vector<std::int64_t> step;  ///< number of the accepted step, ascending; 0 if unknown
  std::vector<double> time_s;
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

/// Curl of a monitor, its last coordinate of displacement [m]; NaN if it has no vertical
/// displacement.
double curl_of(const v1::MonitorValue& monitor);

}  // namespace dccast::client
