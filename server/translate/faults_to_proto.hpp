#pragma once

#include "core/case/case_check.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::translate {

/// The verdict of the core's check.
v1::ValidateCaseResponse to_proto(const casting::CheckedCase& checked);

/// Faults in one text, for a job that turned out invalid only when it began.
std::string in_words(const std::vector<Fault>& faults);

}  // namespace dccast::translate
