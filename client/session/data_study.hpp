#pragma once

#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/study_keys.hpp"
#include "proto/case_file/uncertainty.hpp"

/// Studies over what data and levers of a case may be: `uncertainty`, `sensitivity`, and
/// `calibration` with its measurements and further runs.
namespace dccast::client {

/// What the user chose of a plan.
struct DataPlan {
  /// Runs of the Latin hypercube; the same seed gives the same arrangement.
  int runs = 64;
  std::uint64_t seed = 0;
  std::vector<std::string> only;  ///< keys of data; empty: all
};

/// The case of a request with defaults and alloy card. Throws CommandFailed.
v1::Case complete_case(Connection& connection, const v1::CreateStudyRequest& request);

/// Makes the study of a request a Latin hypercube over data of its case that have a range; the
/// server knows them (docs/uncertainty.md).
void lay_out_uncertainty(const DataPlan& plan, v1::CreateStudyRequest& request);

/// The plan of a calibration: a Latin hypercube over free keys.
struct CalibrationPlan {
  DataPlan data;
  std::vector<std::string> free;  ///< KEY=RANGE, or KEY for its range in [uncertainty]; empty:
                                  ///< every key to which case or card gives a range
  std::vector<v1::MeasuredCurve> measured;
};

/// The same over the free keys of a calibration, with what was measured. Throws CommandFailed.
/// @param axes  of a casting that was laid out before; empty: this is the first
void lay_out_calibration(const CalibrationPlan& plan,
                         const google::protobuf::RepeatedPtrField<v1::SweepPlan::Axis>& axes,
                         v1::CreateStudyRequest& request);

/// The same, with every lever of a plant and every datum alone at the two ends of its range.
void lay_out_sensitivity(const DataPlan& plan, v1::CreateStudyRequest& request);

using case_file::datum_of;

/// The studies of one casting: a Latin hypercube with measurements, then further runs.
using CastingStudies = std::vector<std::string>;

/// Asks what the server concludes from the measurements of some castings, with the figures. Where
/// too few runs have ended, the result has no calibration.
v1::JudgeStudyRequest question_about(const std::vector<CastingStudies>& castings);

/// Begins the runs that check a calibration, in every casting, and adds their studies. The same
/// calibration gives the same studies. @return the new ones; empty: these runs are there already
std::vector<std::string> add_checks(Connection& connection, const v1::Calibration& calibration,
                                    const v1::SweepPlan& plan,
                                    std::vector<CastingStudies>& castings);

}  // namespace dccast::client
