#pragma once

#include <vector>

#include "client/connection.hpp"

namespace dccast::client {

/// Jobs that a request asks for, page by page, newest first, and no more than `limit`.
/// Throws CommandFailed, Interrupted.
/// @param request  its page size and token are set here
std::vector<v1::Job> list_jobs(Connection& connection, v1::ListJobsRequest request, int limit);

/// The same, and whether the server has more than these.
struct JobListing {
  std::vector<v1::Job> jobs;
  bool more = false;
};
JobListing list_some_jobs(Connection& connection, v1::ListJobsRequest request, int limit);

}  // namespace dccast::client
