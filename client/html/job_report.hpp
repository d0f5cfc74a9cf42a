#pragma once

#include <iosfwd>
#include <string>

#include "client/session/connection.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// The report page of a job with all that the server has for it: result, study, frames. See
/// report_page. Throws CommandFailed.
/// @param notes  receives what the page lacks, a line each
std::string report_of(Connection& connection, const v1::Job& job, std::ostream& notes);

}  // namespace dccast::client::render
