#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::studies {

inline constexpr int most_sweep_runs = 10000;

/// The values of every run of a sweep without faults, as in a case file. (run, axis)
std::vector<std::vector<std::string>> sweep_values(const v1::CreateStudyRequest& request);

/// The number that a value of a key stands for, in the unit of the schema; NaN for what is none.
double number_of(const v1::Case& base, const std::string& key, const std::string& value);

/// What mesh and time steps leave uncertain of a curl, relative to it; nothing where it is not
/// known.
/// @param description  case as submitted
std::optional<double> relative_curl_error(v1::Case description);

/// A value between two, as in a case file, in the unit of the first one.
/// @param ends   a key with two numbers  @param place  0 to 1
std::string value_between(const v1::Case& base, const v1::SweepPlan::Axis& ends, double place);

}  // namespace dccast::studies
