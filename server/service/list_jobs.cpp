#include <algorithm>

#include "server/jobs/events.hpp"
#include "server/service/age_token.hpp"
#include "server/service/handlers.hpp"
#include "server/service/labels.hpp"
#include "server/service/message_size.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

namespace {

constexpr int default_page = 50;
constexpr int largest_page = 1000;
// Rows are fetched a few at a time: titles in a store of an earlier version have no bound.
constexpr int rows_at_a_time = 32;

std::string token_after(const v1::Job& job) {
  return age_token(jobs::milliseconds(job.create_time()), job.id());
}

/// Adds jobs until the page is full, by number or by bytes; then there is a next one.
void fill(Context& context, jobs::JobStore::Page rest, int size, v1::ListJobsResponse& response) {
  std::size_t bytes = 0;
  for (;;) {
    rest.size = std::min(rows_at_a_time, size + 1 - response.jobs_size());
    auto jobs = context.scheduler.list(rest);
    const bool last_rows = static_cast<int>(jobs.size()) < rest.size;
    for (v1::Job& job : jobs) {
      fit_into_list(job);
      bytes += job.ByteSizeLong();
      const bool full = response.jobs_size() == size || bytes > page_bytes;
      if (full && response.jobs_size() > 0)
        return response.set_next_page_token(token_after(response.jobs(response.jobs_size() - 1)));
      *response.add_jobs() = std::move(job);
    }
    if (last_rows) return;
    const v1::Job& last = response.jobs(response.jobs_size() - 1);
    rest.before_ms = jobs::milliseconds(last.create_time());
    rest.before_id = last.id();
  }
}

}  // namespace

grpc::Status list_jobs(Context& context, const Call&, const v1::ListJobsRequest& request,
                       v1::ListJobsResponse& response) {
  jobs::JobStore::Page page;
  if (!read_age_token(request.page_token(), page.before_ms, page.before_id))
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "the page_token is not one of ListJobs; begin again without it"};
  if (const auto status = check_study(request.study()); !status.ok()) return status;
  if (const auto status = check_labels(request.labels()); !status.ok()) return status;
  if (request.page_size() < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT, "page_size must not be negative"};
  const int size =
      request.page_size() == 0 ? default_page : std::min(request.page_size(), largest_page);
  for (const int state : request.states()) page.states.push_back(static_cast<v1::JobState>(state));
  page.study = request.study();
  page.owner = request.owner();
  page.id_prefix = request.id_prefix();
  page.labels.assign(request.labels().begin(), request.labels().end());
  fill(context, std::move(page), size, response);
  return grpc::Status::OK;
}

}  // namespace dccast::service
