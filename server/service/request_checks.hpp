#pragma once

#include <google/protobuf/repeated_ptr_field.h>
#include <grpcpp/support/status.h>

#include <cstddef>
#include <cstdint>
#include <string>

#include "dccast/v1/job.pb.h"

/// What requests have in common and is checked alike: OK, or INVALID_ARGUMENT with the remedy.

namespace dccast::service {

struct Call;
struct Context;

grpc::Status check_job_id(const std::string& id);
grpc::Status check_study_id(const std::string& id);
/// Of the study that a job names; it may be empty.
grpc::Status check_study_of_job(const std::string& study);

/// A free text must not be too long, and is one line that can be shown.
grpc::Status check_text(const std::string& name, const std::string& text);
/// At most 20 labels of 1 to 64 bytes, each one line that can be shown.
grpc::Status check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels);
/// No more text than is kept with a job.
grpc::Status check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes);

/// Whether the caller may queue one more job, or has sent this one before. A study begins under
/// the same limit; its jobs are queued few at a time.
grpc::Status may_queue(Context& context, const Call& call, const std::string& request_id = {});

/// What an answer that could go on without end is cut to [bytes]. A client's gRPC takes 4 MiB
/// unless it sets another limit.
inline constexpr std::size_t page_bytes = 1 << 20;

/// What any answer is held to [bytes]: those 4 MiB, less the frame of the message.
inline constexpr std::size_t answer_bytes = (4 << 20) - 4096;

/// A page of a list by age, newest first.
struct AgePage {
  std::int64_t before_ms = INT64_MAX;  ///< only what was created before, or then with a lesser id
  std::string before_id{};
  int size = 50;  ///< 1 to 1000
};

/// @param list   for messages, e.g. "the list of jobs"
/// @param token  "<creation time in ms>.<id>" of the last entry of the page before, or empty
/// @param size   0: the default
grpc::Status read_page(const std::string& list, const std::string& token, int size, AgePage& page);
std::string age_token(std::int64_t created_ms, const std::string& id);

}  // namespace dccast::service
