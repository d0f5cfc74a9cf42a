#include "client/job_listing.hpp"

#include <algorithm>

namespace dccast::client {

std::vector<v1::Job> list_jobs(Connection& connection, v1::ListJobsRequest request, int limit) {
  return list_some_jobs(connection, std::move(request), limit).jobs;
}

JobListing list_some_jobs(Connection& connection, v1::ListJobsRequest request, int limit) {
  constexpr int largest_page = 1000;  // service.proto
  JobListing listing;
  std::vector<v1::Job>& jobs = listing.jobs;
  do {
    request.set_page_size(std::min(largest_page, limit - static_cast<int>(jobs.size())));
    const auto page = connection.call(&Stub::ListJobs, request);
    jobs.insert(jobs.end(), page.jobs().begin(), page.jobs().end());
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty() && static_cast<int>(jobs.size()) < limit);
  listing.more = !request.page_token().empty();
  return listing;
}

}  // namespace dccast::client
