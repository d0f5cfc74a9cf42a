#pragma once

#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/studies/run_results.hpp"
#include "server/studies/study_feeder.hpp"
#include "server/studies/sweep_surfaces.hpp"

namespace dccast::studies {

/// Outcome of a request about one study.
struct StudyReply {
  /// not_found also where the caller may not know that it exists.
  enum class Kind { done, not_found, wrong_state };
  Kind kind = Kind::done;
  v1::Study study{};         ///< current state, unless not_found
  std::string unfinished{};  ///< job that prevents the removal of an ended study
};

/// Requests about studies. All jobs of a study belong to its owner, so that permission for the
/// study is permission for its jobs. Requests throw like those of the Scheduler, and have then
/// changed nothing. Safe to use from several threads.
class StudyRequests {
public:
  /// All outlive this object.
  StudyRequests(StudiesState& state, StudyFeeder& feeder, RunResults& results,
                SweepSurfaces& surfaces)
      : state_(state), feeder_(feeder), results_(results), surfaces_(surfaces) {}

  /// Completes removals that were interrupted and writes missing study files; before the feeder
  /// starts.
  void recover();

  /// Creates a study from a request whose plan and cases are sound; it then survives a crash of
  /// daemon or machine. If the request_id is known, returns that study; queues again its runs whose
  /// jobs were deleted, and adds levels to a refinement study.
  /// @throws jobs::RequestIdTaken, jobs::StorageHeld
  /// @param attachments  files named by the request
  v1::Study create(const v1::CreateStudyRequest& request, const jobs::Attachments& attachments,
                   const std::string& owner);
  /// Completes a request for further runs of a study with the case of that study.
  /// @return files that the case names; empty if there is no such study
  std::optional<jobs::Attachments> complete(v1::CreateStudyRequest& request) const;
  /// Current state of a study; empty if there is no such study.
  std::optional<v1::Study> find(const std::string& id) const;
  /// Studies of a page, newest first.
  std::vector<v1::Study> list(const StudyStore::Page& page) const;
  /// Cancels the runs that have not ended. @param reason  stored in their jobs
  StudyReply cancel(const std::string& id, const std::string& reason);
  /// @param failed  also runs that failed by their own case
  StudyReply resume(const std::string& id, bool failed);
  /// Removes an ended study with its jobs.
  StudyReply remove(const std::string& id);

private:
  /// Writes file and row of a new study, then returns it.
  v1::Study create_new(const v1::CreateStudyRequest& request, const jobs::Attachments& attachments,
                       const std::string& owner, const std::string& case_sha256);
  /// Adds to a study that exists: lost runs, further levels.
  /// @throws jobs::RequestIdTaken  another case or plan
  v1::Study extend(StudyRecord study, const v1::CreateStudyRequest& request,
                   const std::string& case_sha256);
  /// Adds the next run of a plan that outlasts failures: after a resumption there may be one.
  void add_next_run(const StudyRecord& study);
  /// Marks runs as waiting again.
  void queue_again(const StudyRecord& study, std::vector<RunRecord> runs);
  /// Deletes jobs, file and row; continues a removal that was interrupted.
  void remove_now(const StudyRecord& study);

  StudiesState& state_;
  StudyFeeder& feeder_;
  RunResults& results_;
  SweepSurfaces& surfaces_;
  std::mutex mutex_;  ///< serialises creation, resumption and removal
};

}  // namespace dccast::studies
