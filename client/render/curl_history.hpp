#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// Curl of every monitor against time and cast length. Curl is the vertical displacement.
struct CurlHistory {
  struct Series {
    std::string name;
    std::vector<double> curl_m;        ///< one per instant; NaN where the monitor is not reported
    /// Displacement away from the symmetry plane; of a quarter slab its length in plan.
    std::vector<double> horizontal_m;
    std::vector<double> temperature_c;  ///< NaN where the monitor is not poured yet
  };
  std::vector<std::int64_t> step;  ///< number of the accepted step, rising; 0 where it is not said
  std::vector<double> time_s;
  std::vector<double> cast_length_m;
  std::vector<bool> beyond;  ///< the model was no longer valid then
  std::vector<Series> monitors;

  /// A step that was there already replaces itself and all that came after it: it is computed
  /// again.
  void add(const v1::StepReport& report);
  /// Forgets the steps after this one: the run goes on from there. 0: it starts over.
  void rewind(std::int64_t last_step);
  /// Marks the instants from this time on.
  void mark_beyond(double time_s);
  /// The first instant that is beyond validity, as an index; nothing when all are valid.
  std::optional<std::size_t> first_beyond() const;
  /// The monitor whose curl is largest now; null before the first step.
  const Series* largest() const;
};

/// The history of a job as QueryResult has it, marked from the job's loss of validity on.
CurlHistory curl_history(const v1::Job& job, const v1::QueryResultResponse& result);

/// Curl of a monitor, its last coordinate of displacement [m]; NaN if it has no vertical displacement.
double curl_of(const v1::MonitorValue& monitor);

}  // namespace dccast::client::render
