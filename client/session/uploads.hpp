#pragma once

#include <functional>
#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "proto/case_file/case_file.hpp"

namespace dccast::client {

/// Uploads the files of a case that the server does not have yet. A call that finds one of them
/// gone, as after a restart of the server, uploads them again. Throws CommandFailed (a limit, a
/// role that may not upload, a file that has changed since it was read) and Interrupted.
void upload_files(Connection& connection, const std::vector<case_file::AttachedFile>& files);

/// One attempt to upload a file part by part.
/// @param named  with the SHA-256 and size that it has
/// @param next_part  gives the next part, at most 256 kB; empty at the end. What it throws ends the
///                   call.
/// @param response  receives the answer of the server, which may have the file: then it is not read
/// @return the status of the call
grpc::Status upload_parts(Connection& connection, const v1::Attachment& named,
                          const std::function<std::string()>& next_part,
                          v1::UploadAttachmentResponse& response);

}  // namespace dccast::client
