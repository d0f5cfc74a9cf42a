#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "dccast/v1/study.pb.h"

/// A calibration over studies: their measurements, further runs, and the calibrated case.
namespace dccast::client {

/// The studies of one casting: a Latin hypercube with measurements, then further runs.
using CastingStudies = std::vector<std::string>;

/// The calibration of some castings by what was measured of them. Throws CommandFailed, also where
/// too few runs have ended.
v1::StudyResult evaluate_calibration(Connection& connection,
                                     const std::vector<CastingStudies>& castings);

/// Begins the runs that check a calibration, in every casting, and adds their studies. The same
/// calibration gives the same studies. @return the new ones; empty: these runs are there already
std::vector<std::string> add_checks(Connection& connection, const v1::Calibration& calibration,
                                    const v1::SweepPlan& plan,
                                    std::vector<CastingStudies>& castings);

/// Whether the last further runs are about as far off the surface as its error, or by less than a
/// reading is uncertain.
bool is_confirmed(const v1::Calibration::Curve& curve);

/// A case file with the calibrated values, their ranges in [uncertainty] and where they are from.
/// Throws CommandFailed. @param request  has the case as in its file, with its changes
std::string calibrated_case(Connection& connection, const v1::CreateStudyRequest& request,
                            const v1::StudyResult& result);

}  // namespace dccast::client
