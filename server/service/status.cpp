#include "server/service/status.hpp"

#include <spdlog/spdlog.h>

#include <system_error>

#include "proto/values/uuid.hpp"
#include "server/jobs/ask_worker.hpp"
#include "server/jobs/events.hpp"

namespace dccast::service {

namespace {

// Primary result codes of SQLite that mean the disk refuses.
constexpr int sqlite_io_error = 10;
constexpr int sqlite_full = 13;
// With base64 and the message beside it this stays below the 8 KiB of the trailers.
constexpr std::size_t largest_details = 4096;

grpc::Status disk_refuses(const std::string& what) {
  spdlog::error("{}", what);
  return {
      grpc::StatusCode::RESOURCE_EXHAUSTED,
      what + "; the server's data directory takes nothing more: free space there, then try again"};
}

bool is_disk_error(const std::error_code& code) {
  return code == std::errc::no_space_on_device || code == std::errc::file_too_large ||
         code == std::errc::io_error || code == std::errc::read_only_file_system ||
         code.value() == EDQUOT;
}

grpc::Status no_uuid(const std::string& given, const std::string& of_what,
                     const std::string& origin) {
  // Pieced together with +=: g++ 12 sees a wrong overlap in operator+ here.
  std::string message = "\"";
  message += given.substr(0, 64);
  message += "\" is not a " + of_what + " id; an id is a UUID in lower case, " + origin;
  return {grpc::StatusCode::INVALID_ARGUMENT, message};
}

grpc::Status internal(const std::string& what) {
  spdlog::error("{}", what);
  return {grpc::StatusCode::INTERNAL, what};
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
    const bool disk = error.code() == sqlite_full || error.code() == sqlite_io_error;
    return disk ? disk_refuses(error.what()) : internal(error.what());
  } catch (const std::system_error& error) {
    return is_disk_error(error.code()) ? disk_refuses(error.what()) : internal(error.what());
  } catch (const std::exception& error) {
    return internal(error.what());
  }
}

grpc::Status check_id(const std::string& id) {
  if (values::is_uuid(id)) return grpc::Status::OK;
  return no_uuid(id, "job", "as SubmitJob and ListJobs give it");
}

grpc::Status check_study(const std::string& study) {
  if (study.empty() || values::is_uuid(study)) return grpc::Status::OK;
  return no_uuid(study, "study", "chosen by who submits the first job of the study");
}

grpc::Status job_not_found(const std::string& id) {
  return {grpc::StatusCode::NOT_FOUND,
          "there is no job " + id + " here; ListJobs names those there are"};
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
    message +=
        " (" + std::to_string(details.faults_size()) + " given here; ValidateCase gives all)";
  const v1::Fault& first = verdict.faults(0);
  message += "; first: " + first.field() + ": " + first.message().substr(0, 512);
  return {grpc::StatusCode::INVALID_ARGUMENT, message, details.SerializeAsString()};
}

grpc::Status answer(const jobs::Reply& reply, const std::string& id, const std::string& remedy,
                    v1::Job* job) {
  if (reply.kind == jobs::Reply::Kind::not_found) return job_not_found(id);
  if (reply.kind == jobs::Reply::Kind::wrong_state) return wrong_state(reply.job, remedy);
  if (job != nullptr) *job = reply.job;
  return grpc::Status::OK;
}

}  // namespace dccast::service
