#include "server/service/request_checks.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"
#include "server/service/call.hpp"
#include "server/service/context.hpp"

namespace dccast::service {

namespace {

constexpr int most_labels = 20;
constexpr std::size_t longest_label = 64;             // bytes
constexpr std::size_t most_bytes_of_changes = 16384;  // they are shown in lists of 1000 jobs
constexpr int largest_page = 1000;

grpc::Status refused(const std::string& what) {
  return {grpc::StatusCode::INVALID_ARGUMENT, what};
}

grpc::Status check_uuid(const std::string& given, const std::string& of_what,
                        const std::string& origin) {
  if (values::is_uuid(given)) return grpc::Status::OK;
  // Pieced together with +=: g++ 12 sees a wrong overlap in operator+ here.
  std::string message = "\"";
  message += values::escaped(values::shortened(given));
  message += "\" is not a " + of_what + " id; an id is a UUID in lower case, " + origin;
  return refused(message);
}

bool read_age_token(const std::string& token, AgePage& page) {
  if (token.empty()) return true;
  const auto dot = token.find('.');
  if (dot == std::string::npos || !values::is_uuid(token.substr(dot + 1))) return false;
  page.before_id = token.substr(dot + 1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + dot, page.before_ms);
  return error == std::errc() && end == token.data() + dot;
}

}  // namespace

grpc::Status check_job_id(const std::string& id) {
  return check_uuid(id, "job",
                    "as it was given for the job submitted, or stands in the list of jobs");
}

grpc::Status check_study_id(const std::string& id) {
  return check_uuid(id, "study", "chosen by who submits the first job of the study");
}

grpc::Status check_study_of_job(const std::string& study) {
  return study.empty() ? grpc::Status::OK : check_study_id(study);
}

grpc::Status check_text(const std::string& name, const std::string& text) {
  if (const std::string fault = values::too_long(name, text); !fault.empty()) return refused(fault);
  if (const auto character = values::unprintable(text))
    return refused(name + " contains " + *character + "; leave that character out");
  return grpc::Status::OK;
}

grpc::Status check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels) {
  if (labels.size() > most_labels)
    return refused("there are " + std::to_string(labels.size()) + " labels; a job has at most " +
                   std::to_string(most_labels));
  for (const std::string& label : labels) {
    const std::string given = "the label \"" + values::escaped(values::shortened(label)) + "\" ";
    if (label.empty() || label.size() > longest_label)
      return refused(given + "is not one line of 1 to " + std::to_string(longest_label) + " bytes");
    if (const auto character = values::unprintable(label))
      return refused(given + "contains " + *character + "; leave that character out");
  }
  return grpc::Status::OK;
}

grpc::Status check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes) {
  std::size_t bytes = 0;
  for (const v1::CaseChange& change : changes) {
    bytes += change.ByteSizeLong();
    for (const std::string& text : {change.key(), change.value()})
      if (const auto character = values::unprintable(text, values::Lines::several))
        return refused("a change of the case contains " + *character);
  }
  if (bytes <= most_bytes_of_changes) return grpc::Status::OK;
  return refused("the changes of the case take " + std::to_string(bytes) + " bytes; at most " +
                 std::to_string(most_bytes_of_changes) + " are kept: write them into the case");
}

grpc::Status read_page(const std::string& list, const std::string& token, int size, AgePage& page) {
  if (!read_age_token(token, page))
    return refused("the page_token is not one of " + list + "; begin again without it");
  if (size < 0) return refused("page_size must not be negative");
  if (size > 0) page.size = std::min(size, largest_page);
  return grpc::Status::OK;
}

std::string age_token(std::int64_t created_ms, const std::string& id) {
  return std::to_string(created_ms) + "." + id;
}

grpc::Status may_queue(Context& context, const Call& call, const std::string& request_id) {
  const access::Caller& caller = call.caller;
  if (caller.role >= v1::ADMIN) return grpc::Status::OK;
  const auto sent_before =
      request_id.empty() ? std::nullopt : context.store.find_request(request_id);
  if (sent_before && sent_before->job.owner() == caller.name) return grpc::Status::OK;
  if (sent_before)
    return {grpc::StatusCode::ALREADY_EXISTS,
            "another user has submitted a job with this request_id; choose a new one"};
  if (const double most = context.maximum_disk_per_user_bytes; most > 0.0)
    if (const auto held = context.store.bytes_of(caller.name); static_cast<double>(held) >= most)
      return {grpc::StatusCode::RESOURCE_EXHAUSTED,
              "the jobs of " + caller.name + " hold " + std::to_string(held) +
                  " bytes on the server; maximum_disk_per_user = " +
                  std::to_string(std::llround(most)) + " bytes; delete some (dccast delete)"};
  const int unfinished = context.store.unfinished_of(caller.name);
  if (unfinished < context.maximum_queued_per_user) return grpc::Status::OK;
  return {grpc::StatusCode::RESOURCE_EXHAUSTED,
          caller.name + " has " + std::to_string(unfinished) +
              " jobs that have not ended; maximum_queued_per_user = " +
              std::to_string(context.maximum_queued_per_user) +
              "; submit again when some have ended"};
}

}  // namespace dccast::service
