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
#include "proto/refusal/refusal.hpp"
#include "server/intake/case_intake.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/studies/studies.hpp"

/// Checks that requests have in common, and statuses of calls that are refused. Each check throws
/// Refusal with a remedy: INVALID_ARGUMENT, unless its comment names another code.
namespace dccast::service {

struct Call;
struct Context;

using v1::ErrorInfo;

/// Status of a refused call. Handlers throw it, and guarded() returns it.
struct Refusal {
  grpc::Status status;
};

/// What the caller can do.
struct Remedy {
  std::string text;
};

/// A status with the code of its reason, whose message and details follow from the facts.
/// @param detail  further message of the details; null: none
grpc::Status make_status(const refusal::Facts& facts,
                         const google::protobuf::Message* detail = nullptr);

/// Refuses a call. The message is "CAUSE; REMEDY". @throws Refusal
template <class... Arguments>
[[noreturn]] void refuse(refusal::Reason reason, const Remedy& remedy,
                         fmt::format_string<Arguments...> cause, Arguments&&... arguments) {
  throw Refusal{make_status({.reason = reason,
                             .cause = fmt::format(cause, std::forward<Arguments>(arguments)...),
                             .remedy = remedy.text})};
}
/// The same where the cause says what to do, or nothing helps.
template <class... Arguments>
[[noreturn]] void refuse(refusal::Reason reason, fmt::format_string<Arguments...> cause,
                         Arguments&&... arguments) {
  refuse(reason, Remedy{}, cause, std::forward<Arguments>(arguments)...);
}
/// Refuses an invalid request.
template <class... Arguments>
[[noreturn]] void refuse(const Remedy& remedy, fmt::format_string<Arguments...> cause,
                         Arguments&&... arguments) {
  refuse(ErrorInfo::INVALID_REQUEST, remedy, cause, std::forward<Arguments>(arguments)...);
}
template <class... Arguments>
[[noreturn]] void refuse(fmt::format_string<Arguments...> cause, Arguments&&... arguments) {
  refuse(ErrorInfo::INVALID_REQUEST, cause, std::forward<Arguments>(arguments)...);
}

/// Runs a handler and turns any exception into a status with a remedy. Never throws.
grpc::Status guarded(const std::function<void()>& handler);

/// RESOURCE_EXHAUSTED: the pool of the call is full.
grpc::Status too_many_waiting();

/// Ids are UUIDs, so that a path made of one stays in its folder. @throws Refusal  INVALID_ARGUMENT
void check_job_id(const std::string& id);
void check_study_id(const std::string& id);
/// Checks a name of a line, of which a path is made too.
void check_line_name(const std::string& name);
/// Checks the study named by a job; it may be empty.
void check_study_of_job(const std::string& study);
/// Checks that a free text is one printable line of limited length.
void check_text(const std::string& name, const std::string& text);
/// Checks that there are at most 20 labels, each one printable line of 1 to 64 bytes.
void check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels);
/// Whose entries a list shows: `asked`, empty for everyone; the caller where users read only their
/// own. @throws Refusal  PERMISSION_DENIED: others were asked for, of whom a filter must not tell
std::string owner_of_list(const Context& context, const Call& call, const std::string& asked);
/// Checks that the changes are printable and not longer than a job keeps.
void check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes);
/// A run of a study that is to be created.
struct RunOfPlan {
  std::string name{};  ///< for messages: "run 3", "refinement 4"
  int refinement = 0;  ///< in a refinement study; 0 elsewhere
};

/// Refuses a case with faults. The details carry the verdict with `run`. They travel in
/// the trailers of the call, which clients limit to 8 KiB: faults that do not fit are left out, and
/// the message gives their number.
/// @param run  the run that has this case; empty for the single case of a request
void check_verdict(const v1::ValidateCaseResponse& verdict, const RunOfPlan& run = {});

/// Checks that a file is announced with a size and a SHA-256.
void check_attachment(const v1::Attachment& attachment);
/// Names the files of a job, so that a request for another one may have them.
google::protobuf::RepeatedPtrField<v1::Attachment> named_files(const jobs::Attachments& files,
                                                               const std::string& job);
/// The files named by a request, as its caller has uploaded them, or as a job has them that the
/// caller may read. @throws Refusal  ABORTED: a file is not on the server
jobs::Attachments uploaded_files(Context& context, const Call& call,
                                 const google::protobuf::RepeatedPtrField<v1::Attachment>& named);

/// Checks and completes a case. @throws Refusal  the case has faults
intake::ExaminedCase sound_case(Context& context, const Call& call, const v1::Case& submitted,
                                const jobs::Attachments& attachments, const RunOfPlan& run = {});

/// Checks that the caller may queue one more job, unless the job of `request_id` is theirs already.
/// A study is checked once, when it is created, because its jobs are queued a few at a time.
/// @throws Refusal  RESOURCE_EXHAUSTED: a limit of the user; ALREADY_EXISTS: another user's job
void check_may_queue(Context& context, const Call& call, const std::string& request_id = {});

/// @throws Refusal  NOT_FOUND
v1::Job find_job(Context& context, const std::string& id);
/// The same of a job that a request names beside the one that it is about.
/// @throws Refusal  also where it is no job id, or the caller may not read the job
v1::Job readable_job(Context& context, const access::Caller& caller, const std::string& id);
/// NOT_FOUND: there is none, or the caller may not know that there is one. The words are equal.
grpc::Status unknown_job(const std::string& id);
grpc::Status unknown_study(const std::string& id);
grpc::Status unknown_line(const std::string& name);
/// Unwraps what was found for a study. @throws Refusal  NOT_FOUND if that is nothing
template <class Found>
Found of_study(const std::string& id, std::optional<Found> found) {
  if (!found) throw Refusal{unknown_study(id)};
  return std::move(*found);
}

/// Refuses with FAILED_PRECONDITION because of the job's state.
/// @param remedy  for a job that has not ended; an ended one can only be submitted again
[[noreturn]] void refuse_state(const v1::Job& job, const std::string& remedy);

/// Unwraps the job or study that a request has changed. @throws Refusal  NOT_FOUND;
/// FAILED_PRECONDITION with this remedy
v1::Job done(const jobs::Reply& reply, const std::string& id, const std::string& remedy = {});
/// The study of a reply that is done. @throws Refusal  NOT_FOUND or FAILED_PRECONDITION
/// @param remedy  what the caller can do instead
v1::Study done(const studies::StudyReply& reply, const std::string& id,
               const std::string& remedy = {});

/// Size of one page of an answer that continues on further pages [bytes].
inline constexpr std::size_t page_bytes = 1 << 20;

/// Largest answer [bytes]: 4 MiB, which clients of gRPC accept by default, less the framing of the
/// message.
inline constexpr std::size_t answer_bytes = (4 << 20) - 4096;

/// Largest request [bytes]: a case, its file (1 MiB, of SubmitJob) and the other fields.
inline constexpr std::size_t request_bytes = 2'100'000;

/// A page of a list by age, newest first.
struct AgePage {
  std::int64_t before_ms = INT64_MAX;  ///< creation time; equal times are ordered by id
  std::string before_id{};
  int size = 50;  ///< 1 to 1000
};

/// @param list   for messages, e.g. "the list of jobs"
/// @param token  "<creation time in ms>.<id>" of the last entry of the page before, or empty
/// @param size   0: the default
AgePage read_page(const std::string& list, const std::string& token, int size);
/// Token of the page after this job or study.
template <class Entry>
std::string age_token(const Entry& entry) {
  return std::to_string(jobs::milliseconds(entry.create_time())) + "." + entry.id();
}

}  // namespace dccast::service
