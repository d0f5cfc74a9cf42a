#pragma once

#include <vector>

#include "client/session/connection.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client {

/// Uploads the files of a case that the server does not have yet. A call that finds one of them
/// gone, as after a restart of the server, uploads them again. Throws CommandFailed (a limit, a
/// role that may not upload, a file that has changed since it was read) and Interrupted.
void upload_files(Connection& connection, const std::vector<case_file::AttachedFile>& files);

}  // namespace dccast::client
