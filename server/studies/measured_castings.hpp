#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/statistics/principal_components.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// A measured casting and the runs of its case.
struct MeasuredCasting {
  v1::CreateStudyRequest request;  ///< of a Latin hypercube with measured curves
  std::vector<EvaluatedRun> runs;  ///< of the study and of all further ones, with histories
  int last = 0;                    ///< number of runs of the last further study
};

/// Infers the values of the axes from the measured curves (docs/calibration.md). Deterministic.
/// @throws CannotPredict  too few valid runs, axes that differ, no reading within the computed time
v1::Calibration calibration_of(std::vector<MeasuredCasting> castings);

// The curves of a casting, in measured_curve.cpp.

inline constexpr int band_instants = 100;  // points of a computed curve for display

/// Whether a curve was measured as a curl [m], not as a temperature [degC].
bool is_curl(const v1::MeasuredCurve& measured);
const google::protobuf::RepeatedField<double>& values_of(const v1::MeasuredCurve& measured);

/// A monitor's computed history, at the instants at which it is reported.
struct History {
  std::vector<double> time_s, cast_length_m, value;
};

/// What some runs compute for a measured curve.
struct Computed {
  std::vector<double> time_s, cast_length_m;  ///< common instants; mean cast lengths
  std::vector<History> runs;
};

/// @param runs  that count  @throws CannotPredict  no run reports it, or its readings need a time
Computed computed_of(const std::vector<EvaluatedRun>& runs, const v1::MeasuredCurve& measured);

/// Readings within the computed time, with their times. Very many are averaged in groups of
/// neighbours; an average keeps the noise of one reading, because a logger's offset does not
/// average out.
/// @throws CannotPredict  there is none
v1::MeasuredCurve usable(const v1::MeasuredCurve& measured, const Computed& computed);

/// Response surface of a measured curve, at its readings and then at the instants of its band.
class CurveSurface {
public:
  /// @param places  (run, input), 0 to 1  @param used  usable()
  CurveSurface(const Eigen::MatrixXd& places, const Computed& computed,
               const v1::MeasuredCurve& used);

  /// (run, reading and instant) values of the runs themselves.
  static Eigen::MatrixXd figures(const Computed& computed, const v1::MeasuredCurve& used);

  Eigen::Index readings() const { return readings_; }
  /// (place, reading and instant)
  Eigen::MatrixXd means(const Eigen::MatrixXd& places) const { return surface_.means(places); }
  /// (reading, reading) covariance of the leave-one-out error: half of it as observed, half as for
  /// any curve of that magnitude.
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
