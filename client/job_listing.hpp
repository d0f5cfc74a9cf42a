#pragma once

#include <vector>

#include "client/connection.hpp"

namespace dccast::client {

/// Lists the jobs of a request, newest first, at most `limit`; reads all pages that are needed.
/// Throws CommandFailed, Interrupted.
/// @param request  its page size and token are set here
std::vector<v1::Job> list_jobs(Connection& connection, v1::ListJobsRequest request, int limit);

/// A list of jobs, and whether the server has more.
struct JobListing {
  std::vector<v1::Job> jobs;
  bool more = false;
};
JobListing list_some_jobs(Connection& connection, v1::ListJobsRequest request, int limit);

}  // namespace dccast::client
