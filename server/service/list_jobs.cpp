#include <charconv>

#include "proto/values/uuid.hpp"
#include "server/jobs/events.hpp"
#include "server/service/handlers.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

namespace {

constexpr int default_page = 50;
constexpr int largest_page = 1000;

/// A token is "<creation time in ms>.<id>" of the last job of the page before.
bool read_token(const std::string& token, jobs::JobStore::Page& page) {
  if (token.empty()) return true;
  const auto dot = token.find('.');
  if (dot == std::string::npos || !values::is_uuid(token.substr(dot + 1))) return false;
  page.before_id = token.substr(dot + 1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + dot, page.before_ms);
  return error == std::errc() && end == token.data() + dot;
}

}  // namespace

grpc::Status list_jobs(Context& context, const v1::ListJobsRequest& request,
                       v1::ListJobsResponse& response) {
  jobs::JobStore::Page page;
  if (!read_token(request.page_token(), page))
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "the page_token is not one of ListJobs; begin again without it"};
  if (const auto status = check_study(request.study()); !status.ok()) return status;
  if (request.page_size() < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT, "page_size must not be negative"};
  const int size =
      request.page_size() == 0 ? default_page : std::min(request.page_size(), largest_page);
  page.size = size + 1;  // one more tells whether there is a next page
  for (const int state : request.states()) page.states.push_back(static_cast<v1::JobState>(state));
  page.study = request.study();
  auto jobs = context.scheduler.list(page);
  const bool more = static_cast<int>(jobs.size()) > size;
  if (more) jobs.pop_back();
  if (more)
    response.set_next_page_token(std::to_string(jobs::milliseconds(jobs.back().create_time())) +
                                 "." + jobs.back().id());
  for (auto& job : jobs) *response.add_jobs() = std::move(job);
  return grpc::Status::OK;
}

}  // namespace dccast::service
