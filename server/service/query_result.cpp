#include <charconv>
#include <limits>

#include "server/service/handlers.hpp"
#include "server/service/message_size.hpp"
#include "server/service/status.hpp"

namespace dccast::service {

namespace {

bool has_result(const v1::Job& job) {
  for (const v1::Artifact& artifact : job.artifacts())
    if (artifact.name() == "results.h5") return true;
  return false;
}

/// A token is "<sequence of the event>.<step>" of the last step of the page before.
bool read_token(const std::string& token, jobs::StepPlace& place) {
  if (token.empty()) return true;
  const char* end = token.data() + token.size();
  const auto [dot, first] = std::from_chars(token.data(), end, place.sequence);
  if (first != std::errc() || dot == end || *dot != '.' || place.sequence < 1) return false;
  const auto [rest, second] = std::from_chars(dot + 1, end, place.step);
  return second == std::errc() && rest == end;
}

grpc::Status add_steps(Context& context, const v1::QueryResultRequest& request,
                       v1::QueryResultResponse& response) {
  jobs::StepPlace place;
  if (!read_token(request.page_token(), place))
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "the page_token is not one of QueryResult; begin again without it"};
  if (request.page_size() < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT, "page_size must not be negative"};
  const auto most = request.page_size() == 0 ? std::numeric_limits<std::size_t>::max()
                                             : static_cast<std::size_t>(request.page_size());
  const auto page = context.step_indexes.of(request.id())
                        ->page(*context.scheduler.log(request.id()), place, most, page_bytes);
  if (!page)
    return {
        grpc::StatusCode::ABORTED,
        "the run has gone back behind the page before this one; begin again without page_token"};
  response.mutable_steps()->Add(page->steps.begin(), page->steps.end());
  if (page->next)
    response.set_next_page_token(std::to_string(page->next->sequence) + "." +
                                 std::to_string(page->next->step));
  return grpc::Status::OK;
}

/// What comes with the first page only.
grpc::Status add_case_and_frame(Context& context, const Call& call,
                                const v1::QueryResultRequest& request, const v1::Job& job,
                                v1::QueryResultResponse& response) {
  const auto complete = context.store.complete_case(request.id());
  if (complete && !response.mutable_case_()->ParseFromString(*complete))
    return {grpc::StatusCode::DATA_LOSS, "the case of job " + request.id() +
                                             " cannot be read from the job store any more; " +
                                             "dccastd check says what else is damaged"};
  if (!request.frame()) return grpc::Status::OK;
  if (!has_result(job))
    return wrong_state(job, "it has no frame yet: watch it until it has results");
  *response.mutable_frame() = context.intake.last_frame(context.jobs_directory / request.id(),
                                                        patience(call, context.check_timeout));
  return grpc::Status::OK;
}

}  // namespace

grpc::Status query_result(Context& context, const Call& call, const v1::QueryResultRequest& request,
                          v1::QueryResultResponse& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  const auto job = context.scheduler.find(request.id());
  if (!job) return job_not_found(request.id());
  const grpc::Status status = add_steps(context, request, response);
  if (!status.ok() || !request.page_token().empty()) return status;
  *response.mutable_findings() = job->findings();
  return add_case_and_frame(context, call, request, *job, response);
}

}  // namespace dccast::service
