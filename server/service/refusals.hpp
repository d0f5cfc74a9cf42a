#pragma once

#include <fmt/core.h>
#include <google/protobuf/repeated_ptr_field.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "dccast/v1/service.pb.h"
#include "server/intake/case_intake.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/studies/studies.hpp"

/// What requests have in common and is checked alike, and what a client receives instead of an
/// answer. All checks throw Refusal: INVALID_ARGUMENT with the remedy, unless another code is
/// named.
namespace dccast::service {

struct Call;
struct Context;

/// A call that is not answered. Calls throw it, and guarded() makes it their status.
struct Refusal {
  grpc::Status status;
};
template <class... Arguments>
[[noreturn]] void refuse(grpc::StatusCode code, fmt::format_string<Arguments...> why,
                         Arguments&&... arguments) {
  throw Refusal{{code, fmt::format(why, std::forward<Arguments>(arguments)...)}};
}
/// With INVALID_ARGUMENT.
template <class... Arguments>
[[noreturn]] void refuse(fmt::format_string<Arguments...> why, Arguments&&... arguments) {
  refuse(grpc::INVALID_ARGUMENT, why, std::forward<Arguments>(arguments)...);
}

/// Runs a handler; what it throws becomes a status with a remedy. Nothing gets past it.
grpc::Status guarded(const std::function<void()>& handler);

/// RESOURCE_EXHAUSTED: the lane of this call is full.
grpc::Status too_many_waiting();

void check_job_id(const std::string& id);
void check_study_id(const std::string& id);
/// Of the study that a job names; it may be empty.
void check_study_of_job(const std::string& study);
/// A free text must not be too long, and is one line that can be shown.
void check_text(const std::string& name, const std::string& text);
/// At most 20 labels of 1 to 64 bytes, each one line that can be shown.
void check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels);
/// No more text than is kept with a job.
void check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes);
/// A run of a study that is to be created.
struct RunOfPlan {
  std::string name{};  ///< for people: "run 3", "refinement 4"
  int refinement = 0;  ///< in a refinement study; else 0
};

/// The details have the verdict, serialised, and whose it is. They travel in the trailers of the
/// call, which clients limit to 8 KiB: faults that do not fit are left out there, and the message
/// states that.
/// @param run  whose case it is; empty: the one case of the request
void check_verdict(const v1::ValidateCaseResponse& verdict, const RunOfPlan& run = {});

/// A file with a size and a SHA-256.
void check_attachment(const v1::Attachment& attachment);
/// The files that a request names, which its caller has uploaded; ABORTED: one is not there.
jobs::Attachments uploaded_files(Context& context, const Call& call,
                                 const google::protobuf::RepeatedPtrField<v1::Attachment>& named);

/// A case without faults, completed.
intake::ExaminedCase sound_case(Context& context, const Call& call, const v1::Case& submitted,
                                const jobs::Attachments& attachments, const RunOfPlan& run = {});

/// Whether the caller may queue one more job, or has sent this one before; else RESOURCE_EXHAUSTED
/// or ALREADY_EXISTS. A study begins under the same limit; its jobs are queued few at a time.
void check_may_queue(Context& context, const Call& call, const std::string& request_id = {});

/// Refuses with NOT_FOUND.
v1::Job find_job(Context& context, const std::string& id);
[[noreturn]] void refuse_unknown_study(const std::string& id);
/// What was found of the study with this id; NOT_FOUND where that is nothing.
template <class Found>
Found of_study(const std::string& id, std::optional<Found> found) {
  if (!found) refuse_unknown_study(id);
  return std::move(*found);
}

/// FAILED_PRECONDITION: the job's state does not permit it. @param remedy  what to do with a job
/// that has not ended; one that has can only be submitted again
[[noreturn]] void refuse_state(const v1::Job& job, const std::string& remedy);

/// The job or study as a request has left it; else NOT_FOUND, or FAILED_PRECONDITION with this
/// remedy.
v1::Job done(const jobs::Reply& reply, const std::string& id, const std::string& remedy = {});
v1::Study done(const studies::StudyReply& reply, const std::string& id,
               const std::string& remedy = {});

/// What an answer that could go on without end is cut to [bytes]. A client's gRPC takes 4 MiB
/// unless it sets another limit.
inline constexpr std::size_t page_bytes = 1 << 20;

/// What any answer is held to [bytes]: those 4 MiB, less the frame of the message.
inline constexpr std::size_t answer_bytes = (4 << 20) - 4096;

/// What any request is held to [bytes]: a case, its file (1 MiB, of SubmitJob), and what else a
/// request has.
inline constexpr std::size_t request_bytes = 2'100'000;

/// A page of a list by age, newest first.
struct AgePage {
  std::int64_t before_ms = INT64_MAX;  ///< only what was created before, or then with a lesser id
  std::string before_id{};
  int size = 50;  ///< 1 to 1000
};

/// @param list   for messages, e.g. "the list of jobs"
/// @param token  "<creation time in ms>.<id>" of the last entry of the page before, or empty
/// @param size   0: the default
AgePage read_page(const std::string& list, const std::string& token, int size);
/// Of a job or a study.
template <class Entry>
std::string age_token(const Entry& entry) {
  return std::to_string(jobs::milliseconds(entry.create_time())) + "." + entry.id();
}

}  // namespace dccast::service
