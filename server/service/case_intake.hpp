#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "server/jobs/job_folder.hpp"

namespace dccast::service {

/// A case with its defaults and its alloy filled in, and what is wrong with it.
struct ExaminedCase {
  v1::Case complete;
  v1::ValidateCaseResponse verdict;
};

/// Examines cases before they are queued. What single values permit is checked here by the schema;
/// how they fit together is checked by the core, in a process of the worker program: a mesh or
/// temperature file that brings it down costs one answer.
class CaseIntake {
public:
  /// @param worker_program   dccast-worker
  /// @param alloy_directory  further alloy cards; empty: only those that are built in
  /// @param check_directory  where attachments are put while a case is checked
  /// @throws std::runtime_error  an alloy card has faults
  CaseIntake(std::filesystem::path worker_program, std::filesystem::path alloy_directory,
             std::filesystem::path check_directory);

  /// @param faulty_keys  paths of keys that whoever submits could not read
  /// @throws std::system_error, jobs::WorkerDidNotAnswer
  ExaminedCase examine(const v1::Case& submitted, const jobs::Attachments& attachments,
                       std::vector<std::string> faulty_keys = {}) const;

  /// The last stored frame of a job that has ended. @throws jobs::WorkerDidNotAnswer
  v1::Frame last_frame(const std::filesystem::path& job_folder) const;

  const std::vector<v1::Alloy>& alloys() const { return alloys_; }

private:
  /// Fills in defaults and the alloy card. @return what is wrong with single values
  std::vector<v1::Fault> complete(v1::Case& submitted) const;
  v1::ValidateCaseResponse ask_core(const v1::Case& complete, const jobs::Attachments& attachments,
                                    const std::vector<std::string>& faulty_keys) const;

  std::filesystem::path worker_program_;
  std::filesystem::path alloy_directory_;
  std::filesystem::path check_directory_;
  std::vector<v1::Alloy> alloys_;
};

/// SHA-256 of a case and its attachments: two submissions with one request_id are the same when it
/// is. Taken over the case's canonical JSON, which no library version changes.
std::string fingerprint(const v1::Case& submitted, const jobs::Attachments& attachments);

}  // namespace dccast::service
