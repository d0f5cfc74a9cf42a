#pragma once

#include <algorithm>
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// The curve of a monitor; null: there is none.
template <class Curves>
const v1::CurlCurve* find_curve(const Curves& curves, const std::string& monitor) {
  const auto found = std::ranges::find(curves, monitor, &v1::CurlCurve::monitor);
  return found == curves.end() ? nullptr : &*found;
}

/// What studies read of the history of a run: the curl of every monitor, and what limits it.
struct RunCurves {
  std::vector<v1::CurlCurve> curves;    ///< by monitor, all at the instants of the run's steps
  std::optional<double> beyond_from_s;  ///< first step at which the model was no longer valid

  /// [degC] by monitor, at the same instants; NaN where not reported.
  std::map<std::string, std::vector<double>> temperature_c;

  /// [m] by step: least thickness of the side's shell, from the mould contact to the water line.
  std::vector<double> least_shell_m;

  /// Null: the monitor is not reported.
  const v1::CurlCurve* curve(const std::string& monitor) const {
    return find_curve(curves, monitor);
  }
  /// Goes on from the end of the run to a later time: the curls stay, the cast length grows as in
  /// its last step. Does nothing where the run lasted as long.
  void hold_until(double time_s);
  /// Memory that it takes [bytes].
  std::size_t bytes() const;
};

/// Those of all monitors, from the steps of a job.
RunCurves run_curves(const v1::Job& job, std::vector<v1::StepReport> steps);

/// Figures of a curve, one of its fields, at other instants; NaN outside its time.
std::vector<double> at_instants(const std::vector<double>& instants_s, const v1::CurlCurve& curve,
                                const google::protobuf::RepeatedField<double>& figures);

}  // namespace dccast::studies
