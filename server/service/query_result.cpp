#include <algorithm>
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

/// As many steps as fit beside what the response holds already, one at least.
grpc::Status add_steps(Context& context, const v1::QueryResultRequest& request,
                       v1::QueryResultResponse& response) {
  const std::size_t taken = response.ByteSizeLong();
  const std::size_t most_bytes = std::min(page_bytes, answer_bytes - std::min(answer_bytes, taken));
  jobs::StepPlace place;
  if (!read_token(request.page_token(), place))
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "the page_token is not one of QueryResult; begin again without it"};
  if (request.page_size() < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT, "page_size must not be negative"};
  const auto most = request.page_size() == 0 ? std::numeric_limits<std::size_t>::max()
                                             : static_cast<std::size_t>(request.page_size());
  const auto page = context.step_indexes.of(request.id())
                        ->page(*context.scheduler.log(request.id()), place, most, most_bytes);
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

grpc::Status add_frame(Context& context, const Call& call, const v1::QueryResultRequest& request,
                       const v1::Job& job, v1::QueryResultResponse& response) {
  const int number = request.frame_number();
  if (number < 0)
    return {grpc::StatusCode::INVALID_ARGUMENT,
            "frame_number must not be negative: 1 is the first frame, 0 the last"};
  if (!has_result(job))
    return wrong_state(job, "it has no frame yet: watch it until it has results");
  v1::QueryResultResponse stored = context.intake.stored_frame(
      context.jobs_directory / request.id(), number, patience(call, context.check_timeout));
  const int frames = stored.frame_time_s_size();
  if (frames == 0) return wrong_state(job, "its results hold no frame");
  if (!stored.has_frame())
    return {grpc::StatusCode::OUT_OF_RANGE,
            "job " + request.id() + " has " + std::to_string(frames) +
                " frames; ask for one of 1 to " + std::to_string(frames) + ", or 0 for the last"};
  response.MergeFrom(stored);
  return grpc::Status::OK;
}

/// What comes with the first page only.
grpc::Status add_case_and_frame(Context& context, const Call& call,
                                const v1::QueryResultRequest& request, const v1::Job& job,
                                v1::QueryResultResponse& response) {
  *response.mutable_findings() = job.findings();
  const auto complete = context.store.complete_case(request.id());
  if (complete && !response.mutable_case_()->ParseFromString(*complete))
    return {grpc::StatusCode::DATA_LOSS, "the case of job " + request.id() +
                                             " cannot be read from the job store any more; " +
                                             "dccastd check says what else is damaged"};
  make_printable(*response.mutable_case_());
  return request.frame() ? add_frame(context, call, request, job, response) : grpc::Status::OK;
}

std::string megabytes(std::size_t bytes) {
  return std::to_string((bytes + 999'999) / 1'000'000) + " MB";
}

/// An answer that most clients would not take is not sent.
grpc::Status fits_into_answer(const v1::QueryResultResponse& response) {
  if (response.ByteSizeLong() <= answer_bytes) return grpc::Status::OK;
  const std::size_t frame = response.has_frame() ? response.frame().ByteSizeLong() : 0;
  const std::size_t rest = response.ByteSizeLong() - frame;
  const std::string held = ", more than an answer of 4 MiB holds; ";
  if (frame > rest)
    return {grpc::StatusCode::RESOURCE_EXHAUSTED,
            "the frame has " + megabytes(frame) + held + "fetch results.h5, which has it too"};
  return {grpc::StatusCode::RESOURCE_EXHAUSTED,
          "case and first step have " + megabytes(rest) + held + "fetch results.h5"};
}

}  // namespace

grpc::Status query_result(Context& context, const Call& call, const v1::QueryResultRequest& request,
                          v1::QueryResultResponse& response) {
  if (const auto status = check_id(request.id()); !status.ok()) return status;
  const auto job = context.scheduler.find(request.id());
  if (!job) return job_not_found(request.id());
  if (request.page_token().empty()) {
    const grpc::Status status = add_case_and_frame(context, call, request, *job, response);
    if (!status.ok()) return status;
  }
  const grpc::Status status = add_steps(context, request, response);
  return status.ok() ? fits_into_answer(response) : status;
}

}  // namespace dccast::service
