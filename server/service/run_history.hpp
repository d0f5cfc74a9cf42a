#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::service {

struct Context;

/// All accepted steps of a job so far, each once. Empty if the run returned to a checkpoint while
/// they were read. @throws std::exception  the event log cannot be read
std::optional<std::vector<v1::StepReport>> read_steps(Context& context, const std::string& job);

}  // namespace dccast::service
