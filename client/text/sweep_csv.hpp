#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// The runs of a sweep as CSV, with their values, curls in metres and outcome; missing numbers are
/// empty.
std::string sweep_csv(const v1::StudyResult& result);

}  // namespace dccast::client
