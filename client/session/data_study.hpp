#pragma once

#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"
#include "proto/case_file/uncertainty.hpp"

/// Plans of `uncertainty` and `sensitivity`: sweeps over what data and levers may be.
namespace dccast::client {

/// What the user chose of a plan.
struct DataPlan {
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

/// The case of a request with its card and all defaults. Throws CommandFailed, with its faults.
v1::Case completed_case(Connection& connection, const v1::CreateStudyRequest& request);

/// The key that an axis moves: without ".scale", ".offset" or ".shift".
std::string datum_of(const std::string& axis_key);

/// Whether an axis is a lever of the plant rather than a datum.
bool is_lever(const std::string& axis_key);

}  // namespace dccast::client
