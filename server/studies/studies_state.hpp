#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/intake/case_intake.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/jobs/recent.hpp"
#include "server/studies/study_notifier.hpp"
#include "server/studies/study_plan.hpp"
#include "server/studies/study_store.hpp"
#include "server/studies/surface_keeper.hpp"

namespace dccast::studies {

/// Settings of the daemon for studies.
struct StudyOptions {
  std::filesystem::path directory;       ///< of the study files
  std::filesystem::path jobs_directory;  ///< of the jobs' folders
  int waiting = 16;                      ///< most jobs of one study that wait in the queue
  std::chrono::milliseconds check_timeout{30000};
};

/// A run of a study and its job.
struct RunAndJob {
  RunRecord run;
  std::optional<v1::Job> job;  ///< none: not queued yet, refused, or its job was deleted

  bool deleted() const { return !run.job.empty() && !job; }
  v1::JobState state() const { return job ? job->state() : run.outcome; }
  const v1::Finding& failure() const { return job ? job->failure() : run.failure; }
};

/// State shared by the parts of Studies. Safe to use from several threads.
struct StudiesState {
  /// The store, the scheduler and the intake outlive this object.
  StudiesState(StudyOptions study_options, StudyStore& study_store, jobs::Scheduler& of_jobs,
               const intake::CaseIntake& of_cases);

  /// The plan of a study, kept for the next call.
  std::shared_ptr<const StudyPlan> plan_of(const StudyRecord& study);
  /// Jobs that name the study and belong to its owner; other users' jobs are not part of it.
  std::map<std::string, v1::Job> jobs_of(const StudyRecord& study);
  /// The runs of a study by number, each with its job.
  std::vector<RunAndJob> runs_and_jobs(const StudyRecord& study);

  /// Writes the file of a study, or replaces its request.
  void write_file(const StudyRecord& study);
  /// Records runs without a job in the study's file; call before the rows of the store change.
  void append_to_file(const StudyRecord& study, const std::vector<RunRecord>& runs);
  /// Wakes the watchers of a study, and lets its surfaces be built again.
  void note_change(const std::string& id);

  const StudyOptions options;
  StudyStore& store;
  jobs::Scheduler& scheduler;
  const intake::CaseIntake& intake;
  StudyNotifier notifier;
  SurfaceKeeper surface_keeper;
  jobs::Recent<const StudyPlan> plans{32};  ///< by study
  std::mutex queueing_mutex;  ///< makes giving a run its job atomic with its cancellation

private:
  std::mutex files_mutex_;  ///< guards the study files
};

}  // namespace dccast::studies
