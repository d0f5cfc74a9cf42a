#pragma once

#include <string>

#include "dccast/v1/case.pb.h"

#include "server/jobs/job_folder.hpp"

namespace dccast::service {

/// SHA-256 of everything that decides the figures of a run: the complete case without its title and
/// its checkpoints, and its attachments. Two cases with one key have, from one solver, one answer.
/// @param complete  with defaults and alloy card
std::string answer_key(const v1::Case& complete, const jobs::Attachments& attachments);

}  // namespace dccast::service
