#pragma once

#include "dccast/v1/service.pb.h"
#include "server/jobs/job_folder.hpp"

namespace dccast::intake {

/// Where faults of the attachments themselves stand.
inline constexpr const char* attachments_field = "attachments";

/// Checks that attachments have plain, distinct names, that every file the case names is among them
/// (a fault otherwise), and that the case names each of them (a warning otherwise). Which keys name
/// files stands in the schema.
void check_attachment_names(const v1::Case& submitted, const jobs::Attachments& attachments,
                            v1::ValidateCaseResponse& verdict);

}  // namespace dccast::intake
