#pragma once

#include <string>
#include <vector>

#include "client/connection.hpp"

namespace dccast::client {

/// The id of the job that a user means: a whole id, the beginning of one that no other job has, or
/// `last` for the newest job of this user. A text that can be neither is left for the server to
/// refuse. Throws CommandFailed: no such job (not_found), or several (invalid), which it lists.
std::string resolve_job(Connection& connection, const std::string& text);
std::vector<std::string> resolve_jobs(Connection& connection,
                                      const std::vector<std::string>& texts);

/// The shortest beginnings, of 8 characters at least, that tell these ids apart.
std::size_t short_id_length(const std::vector<std::string>& ids);

/// What `--help` says of a JOB.
inline constexpr const char* job_help = "Job id, the beginning of one, or last";

}  // namespace dccast::client
