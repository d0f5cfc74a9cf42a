#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/fingerprint.hpp"
#include "server/jobs/executors/warm_workers.hpp"
#include "server/jobs/folder/result_files.hpp"
#include "server/jobs/recent.hpp"
#include "server/jobs/store/job_store.hpp"

namespace dccast::intake {

/// Largest case that this server accepts, whatever the schema permits.
struct Ceilings {
  std::int64_t nodes = 0;  ///< at the end of the casting
  std::int64_t steps = 0;
  double memory_bytes = 0.0;  ///< estimated
};

/// Memory available to each of `workers` workers [bytes]: nine tenths of the machine's memory, or
/// of the control group's limit, divided by their number.
double memory_per_worker(int workers);

/// A case with defaults and alloy filled in, and its faults.
struct ExaminedCase {
  v1::Case complete;
  v1::ValidateCaseResponse verdict;
};

/// A stored frame of a run: all of it, or one field.
struct FrameChoice {
  int number = 0;        ///< 1 is the first, 0 the last
  std::string field{};   ///< name of a v1::FrameField; empty: mesh and temperature
  bool drawing = false;  ///< as QueryResultRequest has it
};

/// Examines cases before they are queued. The schema checks single values here; the core checks how
/// they fit together, in a worker process, so that a crash over a mesh or temperature file costs
/// only one answer.
class CaseIntake {
public:
  /// @param workers          outlives this object
  /// @param alloy_directory  directory of further alloy cards; empty: only built-in cards
  /// @param check_directory  directory for attachments while a case is checked
  /// @throws std::runtime_error  an alloy card has faults
  CaseIntake(jobs::WarmWorkers& workers, std::filesystem::path alloy_directory,
             std::filesystem::path check_directory, const Ceilings& ceilings);

  /// Examines a case. A sound one is remembered: who validates a case and then submits it waits for
  /// one check.
  /// @param faulty_keys  paths of keys that the client could not read
  /// @param findings     whether a case without faults is judged too, which takes longer
  /// @throws std::system_error, jobs::WorkerDidNotAnswer
  ExaminedCase examine(const v1::Case& submitted, const jobs::Attachments& attachments,
                       std::vector<std::string> faulty_keys, const jobs::CallLimits& waiting,
                       bool findings = false) const;

  /// The fast part of examine(), which needs no worker: fills in defaults and alloy card and checks
  /// single values. A case without faults here may still be impossible to run.
  ExaminedCase complete_case(const v1::Case& submitted, const jobs::Attachments& attachments) const;

  /// Times of all frames that a job has stored, and one frame if its number exists.
  /// @param results  artifact of the job, as published by its worker
  /// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult
  v1::QueryResultResponse stored_frame(const std::filesystem::path& job_folder,
                                       const v1::Artifact& results, const FrameChoice& choice,
                                       const jobs::CallLimits& waiting) const;

  /// The same of a job whose run has not ended, from its journal; no times where it has none yet.
  /// @throws jobs::WorkerDidNotAnswer
  v1::QueryResultResponse frame_so_far(const std::filesystem::path& job_folder,
                                       const FrameChoice& choice,
                                       const jobs::CallLimits& waiting) const;

  /// Fields of a job's frames at points.
  /// @param results  artifact of the job; null: its run has not ended, and its journal is read
  /// @return         without a dimension where there is no frame, without instants where a point
  /// does
  ///                 not have as many coordinates as the mesh
  /// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult
  v1::ProbeResultResponse probe(const std::filesystem::path& job_folder,
                                const v1::Artifact* results, const v1::ProbeResultRequest& request,
                                const jobs::CallLimits& waiting) const;

  const std::vector<v1::Alloy>& alloys() const { return alloys_; }
  const Ceilings& ceilings() const { return ceilings_; }

private:
  v1::QueryResultResponse read_frame(const std::filesystem::path& job_folder,
                                     const FrameChoice& choice, bool running,
                                     const jobs::CallLimits& waiting) const;
  /// A sound case that was examined before.
  struct KnownCase {
    ExaminedCase examined;
    bool has_findings = false;
  };

  ExaminedCase judged(const v1::Case& submitted, const jobs::Attachments& attachments,
                      std::vector<std::string> faulty_keys, const jobs::CallLimits& waiting,
                      bool findings) const;
  /// Fills in defaults and the alloy card. @return faults of single values
  std::vector<v1::Fault> complete(v1::Case& submitted, const jobs::Attachments& attachments) const;
  v1::ValidateCaseResponse ask_core(v1::CheckCase check, const jobs::Attachments& attachments,
                                    const jobs::CallLimits& waiting) const;
  /// Whether the card is attached, or was read at the start: others are read anew for each case.
  bool has_fixed_card(const v1::Case& submitted, const jobs::Attachments& attachments) const;
  /// Finds an attached or known card; the result has faults if there is none.
  case_file::AlloyCard card(const std::string& name, const jobs::Attachments& attachments) const;

  jobs::WarmWorkers& workers_;
  std::filesystem::path alloy_directory_;
  std::filesystem::path check_directory_;
  const Ceilings ceilings_;
  std::vector<v1::Alloy> alloys_;
  static constexpr std::size_t most_known_bytes = 16'000'000;
  const std::unique_ptr<jobs::Recent<KnownCase>> known_ =
      std::make_unique<jobs::Recent<KnownCase>>(most_known_bytes);  ///< by fingerprint
  const std::unique_ptr<jobs::ResultDigests> digests_ = std::make_unique<jobs::ResultDigests>();
};

/// Checks that attachments have plain, distinct names, that every file named in the case is
/// attached (a fault otherwise), and that the case names every attachment (a warning otherwise).
/// The schema marks the keys that name files.
void check_attachment_names(const v1::Case& submitted, const jobs::Attachments& attachments,
                            v1::ValidateCaseResponse& verdict);

/// case_file::fingerprint() of a complete case and its attachments. The same solver gives cases
/// with the same answer equal figures.
std::string fingerprint(const v1::Case& complete, case_file::Same same,
                        const jobs::Attachments& attachments);

/// Job for a sound case; the caller adds owner, priority and the like.
jobs::NewJob new_job(const v1::Case& submitted, const jobs::Attachments& attachments,
                     const ExaminedCase& examined);

v1::Fault fault_of(const std::string& field, const std::string& value, const std::string& message,
                   const std::string& permitted = {}, const std::string& remedy = {});

/// Escapes control characters in all texts of a message, so that they cannot act on a terminal.
void make_printable(google::protobuf::Message& message);

}  // namespace dccast::intake
