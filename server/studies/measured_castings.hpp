#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/statistics/principal_components.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// A casting that was measured, with the runs of its case.
struct MeasuredCasting {
  v1::CreateStudyRequest request;  ///< of a Latin hypercube with measured curves
  std::vector<EvaluatedRun> runs;  ///< of it and of all further studies, with histories
  int last = 0;                    ///< how many of them the last further study has
};

/// The axes inferred from the measured curves (docs/calibration.md). The same runs give the same.
/// @throws CannotPredict  too few valid runs, axes that differ, no reading within the computed time
v1::Calibration calibration_of(std::vector<MeasuredCasting> castings);

// The curves of a casting, in measured_curve.cpp.

inline constexpr int band_instants = 100;  // of a computed curve that is shown

/// Whether a curve was measured as a curl [m], not as a temperature [degC].
bool is_curl(const v1::MeasuredCurve& measured);
const google::protobuf::RepeatedField<double>& values_of(const v1::MeasuredCurve& measured);

/// A computed history of a monitor, where it is reported.
struct History {
  std::vector<double> time_s, cast_length_m, value;
};

/// What some runs computed of a measured curve.
struct Computed {
  std::vector<double> time_s, cast_length_m;  ///< instants that all runs have; mean cast lengths
  std::vector<History> runs;
};

/// @param runs  that count  @throws CannotPredict  no run has it, or its readings need a time
Computed computed_of(const std::vector<EvaluatedRun>& runs, const v1::MeasuredCurve& measured);

/// Readings inside of the computed time, with their times; neighbours averaged where there are
/// many. An average has the noise of one reading: what a logger is off does not average out.
/// @throws CannotPredict  there is none
v1::MeasuredCurve usable(const v1::MeasuredCurve& measured, const Computed& computed);

/// The response surface of a measured curve: at the readings, then at the instants of its band.
class CurveSurface {
public:
  /// @param places  (run, input), 0 to 1  @param used  usable()
  CurveSurface(const Eigen::MatrixXd& places, const Computed& computed,
               const v1::MeasuredCurve& used);

  /// (run, reading and instant) of the runs themselves.
  static Eigen::MatrixXd figures(const Computed& computed, const v1::MeasuredCurve& used);

  Eigen::Index readings() const { return readings_; }
  /// (place, reading and instant)
  Eigen::MatrixXd means(const Eigen::MatrixXd& places) const { return surface_.means(places); }
  /// (reading, reading) of what the surface is off where runs are left out one by one, half of it
  /// as they were, half as any curve of their size.
  Eigen::MatrixXd covariance() const;
  Eigen::RowVectorXd error() const;  ///< by instant: standard deviations of the same
  double error_at_readings() const;  ///< root mean square of the same

private:
  Eigen::Index readings_;
  Eigen::VectorXd at_;  ///< by reading [s]
  statistics::PrincipalComponents surface_;
  Eigen::MatrixXd errors_;  ///< (run, reading and instant)
};

}  // namespace dccast::studies
