#pragma once

#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/study_keys.hpp"
#include "proto/case_file/uncertainty.hpp"

/// Studies over what data and levers of a case may be: `uncertainty`, `sensitivity`, and
/// `calibration` with its measurements, further runs and calibrated case.
namespace dccast::client {

/// What the user chose of a plan.
struct DataPlan {
  /// Runs of the Latin hypercube; the same seed gives the same arrangement.
  int runs = 64;
  std::uint64_t seed = 0;
  std::vector<std::string> only;  ///< keys of data; empty: all
};

/// Has the server complete the case of a request, so that card, mesh and steps are the same in all
/// runs of a plan. @return its data with a range, which the case itself no longer has. Throws
/// CommandFailed.
std::vector<case_file::UncertainKey> complete_case(Connection& connection,
                                                   v1::CreateStudyRequest& request);

/// Makes the study of a request a Latin hypercube over every datum of its case that has a range
/// (docs/uncertainty.md). The case is completed by the server, so that card, mesh and steps are the
/// same in all runs; its quality is draft unless the changes of the request choose another. Throws
/// CommandFailed, also where there is no such datum.
void lay_out_uncertainty(Connection& connection, const DataPlan& plan,
                         v1::CreateStudyRequest& request);

/// The plan of a calibration: a Latin hypercube over free keys.
struct CalibrationPlan {
  DataPlan data;
  std::vector<std::string> free;  ///< KEY=RANGE, or KEY for its range in [uncertainty]; empty:
                                  ///< every key to which case or card gives a range
  std::vector<v1::MeasuredCurve> measured;
};

/// The same over the free keys of a calibration, with what was measured. Throws CommandFailed.
/// @param axes  of a casting that was laid out before; empty: this is the first
void lay_out_calibration(Connection& connection, const CalibrationPlan& plan,
                         const google::protobuf::RepeatedPtrField<v1::SweepPlan::Axis>& axes,
                         v1::CreateStudyRequest& request);

/// The same, with every lever of a plant and every datum alone at the two ends of its range.
void lay_out_sensitivity(Connection& connection, const DataPlan& plan,
                         v1::CreateStudyRequest& request);

using case_file::datum_of;

/// The studies of one casting: a Latin hypercube with measurements, then further runs.
using CastingStudies = std::vector<std::string>;

/// What the server concludes from the measurements of some castings, with the figures. Where too
/// few runs have ended, the result has no calibration. Throws CommandFailed.
v1::StudyJudgement judge_calibration(Connection& connection,
                                     const std::vector<CastingStudies>& castings);

/// Begins the runs that check a calibration, in every casting, and adds their studies. The same
/// calibration gives the same studies. @return the new ones; empty: these runs are there already
std::vector<std::string> add_checks(Connection& connection, const v1::Calibration& calibration,
                                    const v1::SweepPlan& plan,
                                    std::vector<CastingStudies>& castings);

/// A case file with the calibrated values, their ranges in [uncertainty] and where they are from.
/// Throws CommandFailed. @param request  has the case as in its file, with its changes
std::string calibrated_case(Connection& connection, const v1::CreateStudyRequest& request,
                            const v1::StudyResult& result);

}  // namespace dccast::client
