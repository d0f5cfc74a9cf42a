#include "server/service/refusals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <new>
#include <system_error>

#include "core/storage/storage_error.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/service/call.hpp"
#include "server/service/context.hpp"
#include "server/studies/lines.hpp"

namespace dccast::service {

namespace {

constexpr int most_labels = 20;
constexpr std::size_t longest_label = 64;             // bytes
constexpr std::size_t most_bytes_of_changes = 16384;  // they are shown in lists of 1000 jobs
constexpr int largest_page = 1000;
// Primary result codes of SQLite, which only jobs/sqlite.cpp may include.
constexpr int sqlite_read_only = 8;
constexpr int sqlite_io_error = 10;
constexpr int sqlite_corrupt = 11;
constexpr int sqlite_full = 13;
constexpr int sqlite_cannot_open = 14;
constexpr int sqlite_not_a_database = 26;
// Base64, and the message twice, add to this; together they stay below the 8 KiB limit of trailers.
constexpr std::size_t largest_details = 3584;
constexpr std::size_t longest_report = 1024;  // of a bug

grpc::Status refuse_for_full_disk(const std::string& cause) {
  return make_status(
      {.reason = ErrorInfo::STORAGE_FULL,
       .cause = fmt::format("{}; the server's data directory takes nothing more", cause),
       .remedy = "free space there, then try again"});
}

/// Logs the error with the file's name; the caller receives the reason and who can repair it.
grpc::Status refuse_for_file(const std::system_error& error) {
  log::error("{}", values::escaped(error.what()));
  if (storage::is_disk_fault(error.code())) return refuse_for_full_disk(error.what());

  const std::string why = error.code().message();
  if (storage::is_resource_fault(error.code()))
    return make_status({.reason = ErrorInfo::SERVER_OVERLOADED,
                        .cause = fmt::format("the server lacks something ({})", why),
                        .remedy = "try again"});

  return make_status(
      {.reason = ErrorInfo::DAMAGED,
       .cause = fmt::format("a file of this dccastd cannot be used ({})", why),
       .remedy = "its log names the file, and `dccastd check` says what is damaged"});
}

/// The details carry the fault, as those of check_verdict() do.
grpc::Status refuse_upload(const intake::UploadRefused& refused) {
  v1::ValidateCaseResponse details;
  *details.add_faults() = refused.fault();
  return make_status(refused.facts(), &details);
}

grpc::Status report_bug(const std::string& error) {
  log::error("{}", values::escaped(error));
  const std::string shown =
      values::escaped(error.substr(0, longest_report), values::Lines::several);
  return make_status({.reason = ErrorInfo::BUG, .cause = shown});
}

/// Logs the failed SQL; the caller receives the fault of the store and who can repair it.
grpc::Status refuse_for_store(const jobs::StoreError& error) {
  log::error("{}", error.what());

  switch (error.code()) {
    case sqlite_full:
      return refuse_for_full_disk("the job store cannot grow");
    case sqlite_read_only:
      return refuse_for_full_disk("the job store is not writable");
    case sqlite_io_error:
    case sqlite_cannot_open:
      return refuse_for_full_disk("the job store cannot be read or written");

    case sqlite_corrupt:
    case sqlite_not_a_database:
      return make_status(
          {.reason = ErrorInfo::DAMAGED,
           .cause = "the job store of this dccastd, jobs.sqlite in its data directory, is damaged",
           .remedy = "stop it and run `dccastd check --repair`, or restore a backup with `dccastd "
                     "restore`"});

    default:
      return make_status(
          {.reason = ErrorInfo::BUG,
           .cause = fmt::format("the job store did not answer as it should (SQLite code {})",
                                error.code()),
           .remedy = "the log of dccastd says more"});
  }
}

/// The status code depends on whether a retry can help.
grpc::Status refuse_for_worker(const jobs::WorkerDidNotAnswer& error) {
  using Why = jobs::WorkerDidNotAnswer::Why;
  const std::string cause = values::escaped(error.what());
  log::warn("{}", cause);

  switch (error.why()) {
    case Why::called_off:
      return make_status({.reason = ErrorInfo::CALLER_LEFT, .cause = cause});

    case Why::not_started:
    case Why::killed:
      return make_status({.reason = ErrorInfo::BUSY, .cause = cause, .remedy = "try again"});

    // The case may be too much for the settings or the machine.
    case Why::too_slow:
      return make_status(
          {.reason = ErrorInfo::LIMIT_REACHED,
           .cause = fmt::format("{} (checks.timeout in the settings of dccastd)", cause),
           .limit = "checks.timeout",
           .remedy = "try again, or make mesh and tables of the case smaller"});
    case Why::too_large:
      return make_status({.reason = ErrorInfo::CASE_TOO_LARGE,
                          .cause = fmt::format("{} of memory", cause),
                          .remedy = "make mesh and tables of the case smaller"});

    default:
      return report_bug(fmt::format(
          "{}. It is a fault of dccast if it does so again: report it with the case", cause));
  }
}

void check_uuid(const std::string& given, const std::string& kind, const std::string& origin) {
  if (values::is_uuid(given)) return;
  refuse(Remedy{fmt::format("an id is a UUID in lower case, {}", origin)}, "\"{}\" is not a {} id",
         values::shown(given), kind);
}

/// Parses "<creation time in ms>.<id>". @return false: not a token of this form
bool read_age_token(const std::string& token, AgePage& page) {
  if (token.empty()) return true;
  const auto dot = token.find('.');
  if (dot == std::string::npos || !values::is_uuid(token.substr(dot + 1))) return false;

  page.before_id = token.substr(dot + 1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + dot, page.before_ms);
  return error == std::errc() && end == token.data() + dot;
}

grpc::Status not_found(std::string cause, std::string remedy) {
  return make_status(
      {.reason = ErrorInfo::NOT_FOUND, .cause = std::move(cause), .remedy = std::move(remedy)});
}

/// The code of a reason, as refusal.proto has it.
grpc::StatusCode status_code(refusal::Reason reason) {
  switch (reason) {
    case ErrorInfo::INVALID_REQUEST:
    case ErrorInfo::INVALID_CASE:
      return grpc::INVALID_ARGUMENT;
    case ErrorInfo::NOT_FOUND:
      return grpc::NOT_FOUND;
    case ErrorInfo::REQUEST_ID_TAKEN:
      return grpc::ALREADY_EXISTS;
    case ErrorInfo::WRONG_STATE:
      return grpc::FAILED_PRECONDITION;
    case ErrorInfo::OUT_OF_RANGE:
      return grpc::OUT_OF_RANGE;
    case ErrorInfo::NOT_LOGGED_IN:
      return grpc::UNAUTHENTICATED;
    case ErrorInfo::NOT_PERMITTED:
      return grpc::PERMISSION_DENIED;
    case ErrorInfo::LIMIT_REACHED:
    case ErrorInfo::STORAGE_FULL:
    case ErrorInfo::SERVER_OVERLOADED:
    case ErrorInfo::CASE_TOO_LARGE:
    case ErrorInfo::ANSWER_TOO_LARGE:
      return grpc::RESOURCE_EXHAUSTED;
    case ErrorInfo::ATTACHMENT_MISSING:
    case ErrorInfo::CHANGED_MEANWHILE:
      return grpc::ABORTED;
    case ErrorInfo::SHUTTING_DOWN:
    case ErrorInfo::BUSY:
      return grpc::UNAVAILABLE;
    case ErrorInfo::DAMAGED:
      return grpc::DATA_LOSS;
    case ErrorInfo::CALLER_LEFT:
      return grpc::CANCELLED;
    case ErrorInfo::TOO_LATE:
      return grpc::DEADLINE_EXCEEDED;
    case ErrorInfo::UNKNOWN_CALL:
      return grpc::UNIMPLEMENTED;

    case ErrorInfo::BUG:
    case ErrorInfo::REASON_UNSPECIFIED:
    // Protobuf adds these two, which no message holds.
    case v1::ErrorInfo_Reason_ErrorInfo_Reason_INT_MIN_SENTINEL_DO_NOT_USE_:
    case v1::ErrorInfo_Reason_ErrorInfo_Reason_INT_MAX_SENTINEL_DO_NOT_USE_:
      break;
  }
  return grpc::INTERNAL;
}

}  // namespace

grpc::Status make_status(const refusal::Facts& facts, const google::protobuf::Message* detail) {
  const grpc::StatusCode code = status_code(facts.reason);
  return {code, facts.message(), refusal::write_details(code, facts, detail)};
}

grpc::Status guarded(const std::function<void()>& handler) {
  try {
    handler();
    return grpc::Status::OK;

    // Refusals of calls, limits and uploads carry their own remedy.
  } catch (const Refusal& refusal) {
    return refusal.status;
  } catch (const intake::UploadRefused& refused) {
    return refuse_upload(refused);
  } catch (const refusal::LimitReached& limit) {
    return make_status(limit.facts());
  } catch (const intake::UploadBroken& error) {
    return make_status({.reason = ErrorInfo::INVALID_REQUEST, .cause = error.what()});
  } catch (const intake::TooManyUploads& error) {
    return make_status(
        {.reason = ErrorInfo::BUSY, .cause = error.what(), .remedy = "try again in a moment"});
  } catch (const jobs::RequestIdTaken& error) {
    return make_status({.reason = ErrorInfo::REQUEST_ID_TAKEN,
                        .cause = error.what(),
                        .remedy = "choose a new one"});

    // The daemon cannot serve now.
  } catch (const jobs::StorageHeld& error) {
    return make_status({.reason = ErrorInfo::STORAGE_FULL,
                        .cause = error.what(),
                        .remedy = "it goes on by itself once that has passed: try again then"});
  } catch (const jobs::ShuttingDown& error) {
    return make_status({.reason = ErrorInfo::SHUTTING_DOWN,
                        .cause = error.what(),
                        .remedy = "submit again later"});
  } catch (const jobs::FreeSpaceShort& error) {
    log::error("{}", error.what());
    return make_status(error.facts());
  } catch (const jobs::StoreError& error) {
    return refuse_for_store(error);
  } catch (const jobs::WorkerDidNotAnswer& error) {
    return refuse_for_worker(error);
  } catch (const jobs::UnsoundResult& unsound) {
    return make_status({.reason = ErrorInfo::DAMAGED, .cause = unsound.what()});
  } catch (const jobs::DamagedReadings& damaged) {
    return make_status({.reason = ErrorInfo::DAMAGED, .cause = damaged.what()});
  } catch (const studies::DamagedLine& damaged) {
    return make_status({.reason = ErrorInfo::DAMAGED,
                        .cause = damaged.what(),
                        .remedy = "an admin can remove the line: `dccast line forget NAME --all`"});
  } catch (const std::system_error& error) {
    return refuse_for_file(error);
  } catch (const std::bad_alloc&) {
    log::error("out of memory");
    return make_status({.reason = ErrorInfo::SERVER_OVERLOADED,
                        .cause = "dccastd is out of memory",
                        .remedy = "try again later"});

    // Everything else is a bug.
  } catch (const std::exception& error) {
    return report_bug(error.what());
  } catch (...) {
    return report_bug("something was thrown that is no exception");
  }
}

grpc::Status too_many_waiting() {
  return make_status({.reason = ErrorInfo::LIMIT_REACHED,
                      .cause = "too many calls of this kind are waiting already",
                      .limit = "waiting_calls",
                      .remedy = "try again in a moment"});
}

void check_job_id(const std::string& id) {
  check_uuid(id, "job", "as it was given for the job submitted, or stands in the list of jobs");
}

void check_study_id(const std::string& id) {
  check_uuid(id, "study", "chosen by who submits the first job of the study");
}

void check_line_name(const std::string& name) {
  if (studies::is_line_name(name)) return;
  refuse(
      Remedy{"name it like \"pit-3\""},
      "\"{}\" is no name of a line; permitted: 1 to 64 of a-z, A-Z, 0-9, \"-\", \"_\" and \".\", "
      "the first a letter or digit",
      values::shortened(name));
}

void check_study_of_job(const std::string& study) {
  if (!study.empty()) check_study_id(study);
}

void check_text(const std::string& name, const std::string& text) {
  if (const std::string fault = values::too_long(name, text); !fault.empty()) refuse("{}", fault);
  if (const auto character = values::unprintable(text))
    refuse(Remedy{"leave that character out"}, "{} contains {}", name, *character);
}

void check_labels(const google::protobuf::RepeatedPtrField<std::string>& labels) {
  if (labels.size() > most_labels)
    refuse("there are {} labels; a job has at most {}", labels.size(), most_labels);
  for (const std::string& label : labels) {
    const std::string given = fmt::format("the label \"{}\"", values::shown(label));
    if (label.empty() || label.size() > longest_label)
      refuse("{} is not one line of 1 to {} bytes", given, longest_label);
    if (const auto character = values::unprintable(label))
      refuse(Remedy{"leave that character out"}, "{} contains {}", given, *character);
  }
}

std::string owner_of_list(const Context& context, const Call& call, const std::string& asked) {
  const access::Caller& caller = call.caller;
  if (!context.gate.authority().reads_own_only(caller)) return asked;

  if (!asked.empty() && asked != caller.name)
    refuse(ErrorInfo::NOT_PERMITTED, "{} reads only what is their own (read = \"own\")",
           caller.name);
  return caller.name;
}

void check_changes(const google::protobuf::RepeatedPtrField<v1::CaseChange>& changes) {
  std::size_t bytes = 0;
  for (const v1::CaseChange& change : changes) {
    bytes += change.ByteSizeLong();
    for (const std::string& text : {change.key(), change.value()})
      if (const auto character = values::unprintable(text, values::Lines::several))
        refuse("a change of the case contains {}", *character);
  }
  if (bytes > most_bytes_of_changes)
    refuse(Remedy{"write them into the case"},
           "the changes of the case take {} bytes; at most {} are kept", bytes,
           most_bytes_of_changes);
}

void check_verdict(const v1::ValidateCaseResponse& verdict, const RunOfPlan& run) {
  if (verdict.faults_size() == 0) return;

  v1::ValidateCaseResponse details;
  details.set_run(run.name);
  details.set_refinement(run.refinement);
  // As many faults as fit into the trailers of the call.
  for (const v1::Fault& fault : verdict.faults()) {
    *details.add_faults() = fault;
    if (details.ByteSizeLong() <= largest_details) continue;
    details.mutable_faults()->RemoveLast();
    break;
  }

  const std::string prefix = run.name.empty() ? "" : run.name + ": ";
  std::string message = fmt::format("{}the case has {} fault{}", prefix, verdict.faults_size(),
                                    verdict.faults_size() == 1 ? "" : "s");
  if (details.faults_size() < verdict.faults_size())
    message +=
        fmt::format(" ({} given here; validating the case gives all)", details.faults_size());
  const v1::Fault& first = verdict.faults(0);
  message += fmt::format("; first: {}: {}", first.field(), first.message().substr(0, 512));
  throw Refusal{make_status({.reason = ErrorInfo::INVALID_CASE, .cause = message}, &details)};
}

void check_attachment(const v1::Attachment& attachment) {
  const std::string name = values::shown(attachment.name());
  if (!values::is_sha256(attachment.sha256()))
    refuse("the sha256 of attachment \"{}\" is not 64 hexadecimal digits in lower case", name);
  if (attachment.size_bytes() < 0) refuse("the size_bytes of attachment \"{}\" is negative", name);
}

/// A file that a job has, which the caller must be permitted to read.
std::optional<jobs::AttachedFile> file_of_job(Context& context, const Call& call,
                                              const v1::Attachment& named) {
  readable_job(context, call.caller, named.job());
  const auto folder = context.jobs_directory / named.job();
  for (auto& file : jobs::attachments_of(folder, jobs::read_job_description(folder)))
    if (file.name == named.name() && file.sha256 == named.sha256()) return file;
  return std::nullopt;
}

google::protobuf::RepeatedPtrField<v1::Attachment> named_files(const jobs::Attachments& files,
                                                               const std::string& job) {
  google::protobuf::RepeatedPtrField<v1::Attachment> named;
  for (const jobs::AttachedFile& file : files) {
    v1::Attachment& attachment = *named.Add();
    attachment.set_name(file.name);
    attachment.set_sha256(file.sha256);
    attachment.set_size_bytes(file.bytes);
    attachment.set_job(job);
  }
  return named;
}

jobs::Attachments uploaded_files(Context& context, const Call& call,
                                 const google::protobuf::RepeatedPtrField<v1::Attachment>& named) {
  jobs::Attachments files;
  for (const v1::Attachment& attachment : named) {
    check_attachment(attachment);
    auto file = attachment.job().empty() ? context.uploads.find(call.caller.name, attachment)
                                         : file_of_job(context, call, attachment);

    if (!file)
      refuse(ErrorInfo::ATTACHMENT_MISSING, Remedy{"upload it (UploadAttachment), then call again"},
             "attachment \"{}\" (SHA-256 {}) is not on the server",
             values::shown(attachment.name()), attachment.sha256());

    files.push_back(std::move(*file));
  }
  return files;
}

intake::ExaminedCase sound_case(Context& context, const Call& call, const v1::Case& submitted,
                                const jobs::Attachments& attachments, const RunOfPlan& run) {
  auto examined = context.intake.examine(submitted, attachments, {},
                                         waiting_time(call, context.settings.checks().timeout_s()));
  check_verdict(examined.verdict, run);
  return examined;
}

void check_may_queue(Context& context, const Call& call, const std::string& request_id) {
  const access::Caller& caller = call.caller;
  const v1::DaemonConfig& settings = context.settings;
  if (caller.role >= v1::ADMIN) return;

  // A request that is sent again creates no second job, so it counts against no limit.
  if (const auto before =
          request_id.empty() ? std::nullopt : context.store.find_request(request_id)) {
    if (before->job.owner() == caller.name) return;
    refuse(ErrorInfo::REQUEST_ID_TAKEN, Remedy{"choose a new one"},
           "another user has submitted a job with this request_id");
  }

  if (const double most = settings.per_user().maximum_disk_bytes(); most > 0.0)
    if (const auto held = context.store.bytes_of(caller.name); static_cast<double>(held) >= most)
      throw refusal::LimitReached(
          {.cause = fmt::format("the jobs of {} hold {} bytes on the server", caller.name, held),
           .limit = "per_user.maximum_disk",
           .permitted = fmt::format("{} bytes", std::llround(most)),
           .remedy = "delete some (dccast delete)"});

  const int unfinished = context.store.unfinished_of(caller.name);
  if (unfinished >= settings.per_user().maximum_queued())
    throw refusal::LimitReached(
        {.cause = fmt::format("{} has {} jobs that have not ended", caller.name, unfinished),
         .limit = "per_user.maximum_queued",
         .permitted = std::to_string(settings.per_user().maximum_queued()),
         .remedy = "submit again when some have ended"});
}

v1::Job find_job(Context& context, const std::string& id) {
  if (auto job = context.scheduler.find(id)) return std::move(*job);
  throw Refusal{unknown_job(id)};
}

v1::Job readable_job(Context& context, const access::Caller& caller, const std::string& id) {
  check_job_id(id);
  const auto& reading = access::rule_of(*v1::GetJobRequest::descriptor());
  if (const auto status = context.gate.permit_touch(caller, reading, id); !status.ok())
    throw Refusal{status};
  return find_job(context, id);
}

grpc::Status unknown_job(const std::string& id) {
  return not_found(fmt::format("there is no job {} here", id),
                   "the list of jobs names those there are");
}

grpc::Status unknown_study(const std::string& id) {
  return not_found(fmt::format("there is no study {} here", id),
                   "the list of studies names those there are");
}

grpc::Status unknown_line(const std::string& name) {
  return not_found(fmt::format("there is no line \"{}\"", values::shortened(name)),
                   "`dccast line list` names those there are");
}

void refuse_state(const v1::Job& job, const std::string& remedy) {
  const bool ended = jobs::is_terminal(job.state());
  refuse(ErrorInfo::WRONG_STATE,
         Remedy{ended ? "it has ended, submit its case again for another run" : remedy},
         "job {} is {}", job.id(), v1::JobState_Name(job.state()));
}

v1::Job done(const jobs::Reply& reply, const std::string& id, const std::string& remedy) {
  using Kind = jobs::Reply::Kind;
  if (reply.kind == Kind::not_found) throw Refusal{unknown_job(id)};
  if (reply.kind == Kind::wrong_state) refuse_state(reply.job, remedy);
  if (reply.kind == Kind::being_cancelled)
    refuse(ErrorInfo::CHANGED_MEANWHILE, Remedy{"try again when its worker has left it"},
           "job {} is being cancelled", id);
  return reply.job;
}

v1::Study done(const studies::StudyReply& reply, const std::string& id, const std::string& remedy) {
  using Kind = studies::StudyReply::Kind;
  if (reply.kind == Kind::not_found) throw Refusal{unknown_study(id)};
  if (reply.kind == Kind::wrong_state && !reply.unfinished.empty())
    refuse(ErrorInfo::WRONG_STATE, Remedy{remedy}, "job {} of study {} has not ended",
           reply.unfinished, id);
  if (reply.kind == Kind::wrong_state)
    refuse(ErrorInfo::WRONG_STATE, Remedy{remedy}, "study {} is {}", id,
           v1::StudyState_Name(reply.study.state()));
  return reply.study;
}

AgePage read_page(const std::string& list, const std::string& token, int size) {
  AgePage page;
  if (!read_age_token(token, page))
    refuse(Remedy{"begin again without it"}, "the page_token is not one of {}", list);
  if (size < 0) refuse("page_size must not be negative");
  if (size > 0) page.size = std::min(size, largest_page);
  return page;
}

}  // namespace dccast::service
