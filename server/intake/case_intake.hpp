#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "server/jobs/executors/warm_workers.hpp"
#include "server/jobs/folder/result_files.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::intake {

/// How large a case may be here, whatever it permits itself.
struct Ceilings {
  std::int64_t nodes = 0;  ///< at its end
  std::int64_t steps = 0;
  double memory_bytes = 0.0;  ///< as estimated
};

/// The memory each of so many workers can have on this machine: its memory, or what the control
/// group leaves of it, less a tenth for everything else [bytes].
double memory_per_worker(int workers);

/// A case with its defaults and its alloy filled in, and what is wrong with it.
struct ExaminedCase {
  v1::Case complete;
  v1::ValidateCaseResponse verdict;
};

/// A stored frame of a run: all of it, or one field.
struct FrameChoice {
  int number = 0;       ///< 1 is the first, 0 the last
  std::string field{};  ///< name of a v1::FrameField; empty: mesh and temperature
};

/// Examines cases before they are queued. What single values permit is checked here by the schema;
/// how they fit together is checked by the core, in a worker: a mesh or temperature file that
/// brings it down costs one answer.
class CaseIntake {
public:
  /// @param workers          outlives this object
  /// @param alloy_directory  further alloy cards; empty: only those that are built in
  /// @param check_directory  where attachments are put while a case is checked
  /// @throws std::runtime_error  an alloy card has faults
  CaseIntake(jobs::WarmWorkers& workers, std::filesystem::path alloy_directory,
             std::filesystem::path check_directory, const Ceilings& ceilings);

  /// @param faulty_keys  paths of keys that the client could not read
  /// @param findings     also those of a case without faults, which takes longer
  /// @throws std::system_error, jobs::WorkerDidNotAnswer
  ExaminedCase examine(const v1::Case& submitted, const jobs::Attachments& attachments,
                       std::vector<std::string> faulty_keys, const jobs::CallLimits& waiting,
                       bool findings = false) const;

  /// The part of examine() that needs no worker, and takes no longer than a look into a table: the
  /// case with defaults and alloy card. A verdict without faults does not mean that it can be run.
  ExaminedCase complete_case(const v1::Case& submitted, const jobs::Attachments& attachments) const;

  /// The times of all frames that a job has stored, and one of them; without it when there are
  /// fewer. @param results  of the job, as its worker published them
  /// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult
  v1::QueryResultResponse stored_frame(const std::filesystem::path& job_folder,
                                       const v1::Artifact& results, const FrameChoice& choice,
                                       const jobs::CallLimits& waiting) const;

  /// The same of a job whose run has not ended, from its journal; no times where it has none yet.
  /// @throws jobs::WorkerDidNotAnswer
  v1::QueryResultResponse frame_so_far(const std::filesystem::path& job_folder,
                                       const FrameChoice& choice,
                                       const jobs::CallLimits& waiting) const;

  const std::vector<v1::Alloy>& alloys() const { return alloys_; }
  const Ceilings& ceilings() const { return ceilings_; }

private:
  v1::QueryResultResponse read_frame(const std::filesystem::path& job_folder,
                                     const FrameChoice& choice, bool running,
                                     const jobs::CallLimits& waiting) const;
  ExaminedCase judged(const v1::Case& submitted, const jobs::Attachments& attachments,
                      std::vector<std::string> faulty_keys, const jobs::CallLimits& waiting,
                      bool findings) const;
  /// Fills in defaults and the alloy card. @return what is wrong with single values
  std::vector<v1::Fault> complete(v1::Case& submitted, const jobs::Attachments& attachments) const;
  v1::ValidateCaseResponse ask_core(v1::CheckCase check, const jobs::Attachments& attachments,
                                    const jobs::CallLimits& waiting) const;
  /// The card of this name, attached or known; with faults when there is none.
  case_file::AlloyCard card(const std::string& name, const jobs::Attachments& attachments) const;

  jobs::WarmWorkers& workers_;
  std::filesystem::path alloy_directory_;
  std::filesystem::path check_directory_;
  const Ceilings ceilings_;
  std::vector<v1::Alloy> alloys_;
  const std::unique_ptr<jobs::ResultDigests> digests_ = std::make_unique<jobs::ResultDigests>();
};

/// Checks that attachments have plain, distinct names, that every file the case names is among them
/// (a fault otherwise), and that the case names each of them (a warning otherwise). Which keys name
/// files stands in the schema.
void check_attachment_names(const v1::Case& submitted, const jobs::Attachments& attachments,
                            v1::ValidateCaseResponse& verdict);

/// SHA-256 of a case and its attachments: two submissions with one request_id are the same when it
/// is. Taken over the case's canonical JSON, which no library version changes.
std::string fingerprint(const v1::Case& submitted, const jobs::Attachments& attachments);

/// SHA-256 of everything that decides the figures of a run: the complete case without its title and
/// its checkpoints, and its attachments. Two cases with one key have, from one solver, one answer.
/// @param complete  with defaults and alloy card
std::string answer_key(v1::Case complete, const jobs::Attachments& attachments);

/// A job of a case that was found good; who wants it, and how, is to be added.
jobs::NewJob new_job(const v1::Case& submitted, const jobs::Attachments& attachments,
                     const ExaminedCase& examined);

v1::Fault fault_of(const std::string& field, const std::string& value, const std::string& message,
                   const std::string& permitted = {}, const std::string& remedy = {});

/// Writes out what would act on a terminal in every text of a message. Cases of today are held
/// against that when they are taken; those of an earlier version may hold anything.
void make_printable(google::protobuf::Message& message);

}  // namespace dccast::intake
