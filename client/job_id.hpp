#pragma once

#include <string>
#include <vector>

#include "client/connection.hpp"

namespace dccast::client {

/// The id of the job that a user means: a complete id, a unique beginning of one, or `last` for the
/// newest job of this user. Any other text is passed on for the server to reject. Throws
/// CommandFailed: no such job (not_found), or several (invalid), which the message lists.
std::string resolve_job(Connection& connection, const std::string& text);
std::vector<std::string> resolve_jobs(Connection& connection,
                                      const std::vector<std::string>& texts);

/// Length of the shortest prefix, at least 8 characters, that distinguishes these ids.
std::size_t short_id_length(const std::vector<std::string>& ids);

/// Help text of a JOB argument.
inline constexpr const char* job_help = "Job id, the beginning of one, or last";

}  // namespace dccast::client
