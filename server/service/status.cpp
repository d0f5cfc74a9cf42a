#include "server/service/status.hpp"

#include <new>
#include <system_error>

#include "core/storage/storage_error.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/worker_process.hpp"

namespace dccast::service {

namespace {

// Primary result codes of SQLite, which only jobs/sqlite.cpp may include.
constexpr int sqlite_read_only = 8;
constexpr int sqlite_io_error = 10;
constexpr int sqlite_corrupt = 11;
constexpr int sqlite_full = 13;
constexpr int sqlite_cannot_open = 14;
constexpr int sqlite_not_a_database = 26;
// With base64 and the message beside it this stays below the 8 KiB of the trailers.
constexpr std::size_t largest_details = 4096;

grpc::Status disk_refuses(const std::string& what) {
  return {
      grpc::StatusCode::RESOURCE_EXHAUSTED,
      what + "; the server's data directory takes nothing more: free space there, then try again"};
}

grpc::Status internal(const std::string& what) {
  const std::string shown = values::escaped(what, values::Lines::several);
  log::error("{}", values::escaped(what));
  return {grpc::StatusCode::INTERNAL, shown};
}

/// The log has the SQL that failed; a caller receives what is wrong with the store and who repairs
/// it.
grpc::Status store_refuses(const jobs::StoreError& error) {
  log::error("{}", error.what());
  switch (error.code()) {
    case sqlite_full:
      return disk_refuses("the job store cannot grow");
    case sqlite_read_only:
      return disk_refuses("the job store is not writable");
    case sqlite_io_error:
    case sqlite_cannot_open:
      return disk_refuses("the job store cannot be read or written");
    case sqlite_corrupt:
    case sqlite_not_a_database:
      return {
          grpc::StatusCode::DATA_LOSS,
          "the job store of this dccastd, jobs.sqlite in its data directory, is damaged; stop it "
          "and run `dccastd check --repair`, or restore a backup with `dccastd restore`"};
    default:
      return {grpc::StatusCode::INTERNAL,
              "the job store did not answer as it should (SQLite code " +
                  std::to_string(error.code()) + "); the log of dccastd says more"};
  }
}

/// Whether asking again can help decides the code.
grpc::Status not_answered(const jobs::WorkerDidNotAnswer& error) {
  using Why = jobs::WorkerDidNotAnswer::Why;
  const std::string what = values::escaped(error.what());
  log::warn("{}", what);
  switch (error.why()) {
    case Why::called_off:
      return {grpc::StatusCode::CANCELLED, what};
    case Why::not_started:
    case Why::killed:
      return {grpc::StatusCode::UNAVAILABLE, what + "; try again"};
    case Why::too_slow:
      return {grpc::StatusCode::RESOURCE_EXHAUSTED,
              what +
                  " (check_timeout in the settings of dccastd); try again, or make mesh and "
                  "tables of the case smaller"};
    case Why::too_large:
      return {grpc::StatusCode::RESOURCE_EXHAUSTED,
              what + " of memory; make mesh and tables of the case smaller"};
    default:
      return internal(what +
                      ". It is a fault of dccast if it does so again: report it with the case");
  }
}

}  // namespace

grpc::Status guarded(const std::function<grpc::Status()>& handler) {
  try {
    return handler();
  } catch (const jobs::QueueFull& error) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED, error.what()};
  } catch (const jobs::RequestIdTaken& error) {
    return {grpc::StatusCode::ALREADY_EXISTS, error.what()};
  } catch (const jobs::StorageHeld& error) {
    return {grpc::StatusCode::RESOURCE_EXHAUSTED, error.what()};
  } catch (const jobs::ShuttingDown& error) {
    return {grpc::StatusCode::UNAVAILABLE, error.what()};
  } catch (const jobs::StoreError& error) {
    return store_refuses(error);
  } catch (const jobs::WorkerDidNotAnswer& error) {
    return not_answered(error);
  } catch (const std::system_error& error) {
    if (!storage::is_disk_fault(error.code())) return internal(error.what());
    log::error("{}", error.what());
    return disk_refuses(error.what());
  } catch (const std::bad_alloc&) {
    log::error("out of memory");
    return {grpc::StatusCode::RESOURCE_EXHAUSTED, "dccastd is out of memory; try again later"};
  } catch (const std::exception& error) {
    return internal(error.what());
  } catch (...) {
    return internal("something was thrown that is no exception");
  }
}

grpc::Status too_many_waiting() {
  return {grpc::StatusCode::RESOURCE_EXHAUSTED,
          "too many calls of this kind are waiting already; try again in a moment"};
}

grpc::Status job_not_found(const std::string& id) {
  return {grpc::StatusCode::NOT_FOUND,
          "there is no job " + id + " here; the list of jobs names those there are"};
}

grpc::Status study_not_found(const std::string& id) {
  return {grpc::StatusCode::NOT_FOUND,
          "there is no study " + id + " here; the list of studies names those there are"};
}

grpc::Status wrong_state(const v1::Job& job, const std::string& remedy) {
  const bool ended = jobs::is_terminal(job.state());
  return {grpc::StatusCode::FAILED_PRECONDITION,
          "job " + job.id() + " is " + v1::JobState_Name(job.state()) + "; " +
              (ended ? "it has ended, submit its case again for another run" : remedy)};
}

grpc::Status faulty_case(const v1::ValidateCaseResponse& verdict) {
  v1::ValidateCaseResponse details;
  for (const v1::Fault& fault : verdict.faults()) {
    *details.add_faults() = fault;
    if (details.ByteSizeLong() <= largest_details) continue;
    details.mutable_faults()->RemoveLast();
    break;
  }
  std::string message = "the case has " + std::to_string(verdict.faults_size()) + " fault" +
                        (verdict.faults_size() == 1 ? "" : "s");
  if (details.faults_size() < verdict.faults_size())
    message += " (" + std::to_string(details.faults_size()) +
               " given here; validating the case gives all)";
  const v1::Fault& first = verdict.faults(0);
  message += "; first: " + first.field() + ": " + first.message().substr(0, 512);
  return {grpc::StatusCode::INVALID_ARGUMENT, message, details.SerializeAsString()};
}

grpc::Status status_of(const jobs::Reply& reply, const std::string& id, const std::string& remedy,
                       v1::Job* job) {
  if (reply.kind == jobs::Reply::Kind::not_found) return job_not_found(id);
  if (reply.kind == jobs::Reply::Kind::wrong_state) return wrong_state(reply.job, remedy);
  if (reply.kind == jobs::Reply::Kind::being_cancelled)
    return {grpc::StatusCode::ABORTED,
            "job " + id + " is being cancelled; try again when its worker has left it"};
  if (job != nullptr) *job = reply.job;
  return grpc::Status::OK;
}

grpc::Status status_of(const studies::StudyReply& reply, const std::string& id,
                       const std::string& remedy, v1::Study* study) {
  using Kind = studies::StudyReply::Kind;
  if (reply.kind == Kind::not_found) return study_not_found(id);
  if (reply.kind == Kind::wrong_state)
    return {grpc::StatusCode::FAILED_PRECONDITION,
            "study " + id + " is " + v1::StudyState_Name(reply.study.state()) + "; " + remedy};
  if (study != nullptr) *study = reply.study;
  return grpc::Status::OK;
}

}  // namespace dccast::service
