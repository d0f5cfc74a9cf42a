#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::figures {

/// The figures of one monitor by step; NaN where it is not reported.
struct MonitorSeries {
  std::string name;
  std::vector<double> curl_m{};
  /// How far mesh and time steps may have put the true curl below and above [m]; NaN: not known.
  std::vector<double> lower_error_m{}, upper_error_m{};
  std::vector<double> temperature_c{};  ///< NaN until metal reaches the monitor
  /// Horizontal displacement [m]: away from the symmetry plane in a section, its x and y component
  /// in a quarter slab.
  std::vector<std::vector<double>> horizontal_m{};

  /// Whether the error of the last curl is known.
  bool has_error() const;
};

/// The accepted steps of a run, each once.
struct RunHistory {
  std::vector<v1::StepReport> steps;  ///< by time

  /// Adds a step. A step that is already present replaces itself and all later ones: the run was
  /// resumed.
  void add(const v1::StepReport& step);
  /// Removes the steps after this one, from which the run continues. 0: the run starts again.
  void rewind(std::int64_t last_step);
  /// Marks the steps from this time on [s] as beyond validity.
  void mark_beyond(double from_s);

  std::vector<double> time_s() const;         ///< (step) [s]
  std::vector<double> cast_length_m() const;  ///< (step) [m]
  std::vector<bool> beyond() const;           ///< (step) the model was no longer valid
  /// First time beyond validity [s]; empty if all are valid.
  std::optional<double> beyond_from_s() const;

  /// Monitors that were reported, in the order in which they were first reported.
  std::vector<std::string> monitors() const;
  MonitorSeries series(const std::string& monitor) const;
  /// Curl of a monitor (step) [m]. Empty for a monitor that is never reported.
  std::vector<double> curl_m(const std::string& monitor) const;
};

/// The history of a job from its steps, marked from the job's loss of validity on.
RunHistory run_history(const v1::Job& job, std::vector<v1::StepReport> steps);

/// A monitor of a step by its name; one without figures where the step has none of that name.
const v1::MonitorValue& monitor_of(const v1::StepReport& step, const std::string& name);

/// Curl of a monitor [m]; NaN where it has none.
double curl_of(const v1::MonitorValue& monitor);

/// The monitor whose curl is judged; null: none has a curl.
const v1::MonitorValue* judged_curl(const v1::StepReport& step);

}  // namespace dccast::figures
