#pragma once

#include <chrono>
#include <climits>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "server/intake/case_intake.hpp"
#include "server/jobs/executors/worker_process.hpp"
#include "server/jobs/logs/step_index.hpp"
#include "server/jobs/queue/scheduler.hpp"
#include "server/jobs/recent.hpp"
#include "server/studies/predictions.hpp"
#include "server/studies/study_notifier.hpp"
#include "server/studies/study_plan.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::studies {

/// Settings of the daemon for studies.
struct StudyOptions {
  std::filesystem::path directory;       ///< of the study files
  std::filesystem::path jobs_directory;  ///< of the jobs' folders
  int waiting = 16;                      ///< most jobs of one study that wait in the queue
  std::chrono::milliseconds check_timeout{30000};
};

/// Outcome of a request about one study.
struct StudyReply {
  /// not_found also where the caller may not know that it exists.
  enum class Kind { done, not_found, wrong_state };
  Kind kind = Kind::done;
  v1::Study study{};         ///< current state, unless not_found
  std::string unfinished{};  ///< job that prevents the removal of an ended study
};

/// Studies: each is a plan in the store, and a feeder queues its runs as jobs, a few at a time. A
/// study that create() has returned survives a crash of daemon or machine. All jobs of a study
/// belong to its owner, so that permission for the study is permission for its jobs.
///
/// Safe to use from several threads. Requests throw like those of the Scheduler, and have then
/// changed nothing.
class Studies {
public:
  /// @param scheduler, intake  outlive this object
  Studies(StudyOptions options, StudyStore& store, jobs::Scheduler& scheduler,
          const intake::CaseIntake& intake);
  /// Ends feeder and surface keeper; see stop().
  ~Studies();

  /// Repairs what the previous daemon left unfinished; call before start().
  void recover();
  /// Starts to queue runs.
  void start();
  /// Stops queueing runs and waking watchers.
  void stop();

  /// Creates a study from a request whose plan and cases are sound. If the request_id is known,
  /// returns that study; queues again its runs whose jobs were deleted, and adds levels to a
  /// refinement study. @throws jobs::RequestIdTaken, jobs::StorageHeld
  /// @param attachments  files named by the request
  v1::Study create(const v1::CreateStudyRequest& request, const jobs::Attachments& attachments,
                   const std::string& owner);
  /// Completes a request for further runs of a study with the case of that study.
  /// @return files that the case names; empty if there is no such study
  std::optional<jobs::Attachments> complete(v1::CreateStudyRequest& request) const;
  /// Current state of a study; empty if there is no such study.
  std::optional<v1::Study> find(const std::string& id);
  /// Studies of a page, newest first.
  std::vector<v1::Study> list(const StudyStore::Page& page);
  /// Cancels the runs that have not ended. @param reason  stored in their jobs
  StudyReply cancel(const std::string& id, const std::string& reason);
  /// @param failed  also runs that failed by their own case
  StudyReply resume(const std::string& id, bool failed);
  /// Removes an ended study with its jobs.
  StudyReply remove(const std::string& id);
  /// Current results of a study; empty if there is no such study.
  std::optional<v1::StudyResult> evaluate(const v1::EvaluateStudyRequest& request);
  /// @return empty if there is no such study
  /// @throws OutsideDomain, CannotPredict
  std::optional<v1::Prediction> predict(const v1::PredictStudyRequest& request);

  /// For watchers of studies.
  StudyNotifier& notifier() { return notifier_; }

private:
  /// The feeder's loop: feeds every study that has runs to queue, then rests.
  void feed(const std::stop_token& stop);
  /// Queues one run of a study if it has room. @return whether another look may queue more
  /// @throws std::exception  nothing can be queued now
  bool feed_study(const std::string& id);
  /// Makes the job of one run, or refuses the run where its case is rejected.
  void feed_run(const StudyRecord& study, const RunRecord& run, const PlannedRun& planned);
  /// Queues the next run of a growing plan, or drops it if the plan is finished.
  /// @return false: a run on which it depends has not ended
  bool feed_grown(const StudyRecord& study, const StudyPlan& plan, const RunRecord& run);
  /// Marks a run as failed without a job, because its case was rejected.
  void refuse(const StudyRecord& study, RunRecord run, const std::string& why);
  /// Does nothing if the run has been cancelled meanwhile.
  void make_job(const StudyRecord& study, RunRecord run, const std::string& key, jobs::NewJob job);
  /// Makes the feeder look again soon.
  void wake_feeder();
  /// Wakes the watchers of a study.
  void note_change(const std::string& id);
  /// Waits until there is work, at most for this time.
  void rest(const std::stop_token& stop, std::chrono::steady_clock::duration most);

  /// A record as clients see it, with counts of its runs.
  v1::Study view(const StudyRecord& record);
  /// The plan of a study, kept for the next call.
  std::shared_ptr<const StudyPlan> plan_of(const StudyRecord& record);
  /// Writes file and row of a new study, then returns it.
  v1::Study create_new(const v1::CreateStudyRequest& request, const jobs::Attachments& attachments,
                       const std::string& owner, const std::string& case_sha256);
  /// Adds to a study that exists: lost runs, further levels.
  /// @throws jobs::RequestIdTaken  another case or plan
  v1::Study take_up(StudyRecord record, const v1::CreateStudyRequest& request,
                    const std::string& case_sha256);
  /// Records runs without a job in the study's file, then in the index.
  void keep(const StudyRecord& record, const std::vector<RunRecord>& runs);
  /// After a resumption: adds the next run of a study that outlasts failures, up to its bound.
  void grow_again(const StudyRecord& record);
  /// Marks runs as waiting again.
  void queue_again(const StudyRecord& record, std::vector<RunRecord> runs);
  /// Deletes jobs, file and row; continues a removal that was interrupted.
  void remove_now(const StudyRecord& study);
  /// Jobs that name the study and belong to its owner; other users' jobs are not part of it.
  std::map<std::string, v1::Job> jobs_of(const StudyRecord& study);

  /// A run of a study and its job.
  struct RunAndJob {
    RunRecord run;
    std::optional<v1::Job> job;  ///< none: not queued yet, refused, or its job was deleted

    bool deleted() const { return !run.job.empty() && !job; }
  };
  /// The runs of a study by number, each with its job.
  std::vector<RunAndJob> runs_and_jobs(const StudyRecord& study);

  /// Curves of a job, from its event log or kept from before.
  RunCurves history_of(const v1::Job& job);
  /// Contour of the wide face of a run, from its last frame; kept after the first call.
  /// @throws jobs::WorkerDidNotAnswer, jobs::UnsoundResult, frames::NoContraction
  std::shared_ptr<const RunFace> face_of(const v1::Job& job);
  /// Adds the face of a job to a run, where it has one.
  void add_face(const v1::Job& job, EvaluatedRun& run);
  /// What is read for an evaluation.
  struct Depth {
    bool histories = false;
    bool faces = false;
    int before = INT_MAX;  ///< only runs with a lower number
  };
  /// Runs of a study with the results that `depth` asks for. Runs of deleted jobs are omitted.
  std::vector<EvaluatedRun> evaluated_runs(const StudyRecord& record, const Depth& depth);
  /// @param record  outlives the result
  SweepState sweep_state(const StudyRecord& record);
  /// Calibrates with the runs of all castings. @throws CannotPredict
  v1::Calibration calibration(const v1::EvaluateStudyRequest& request);
  /// Builds the response surface of a sweep from its succeeded runs.
  void ready_surface(const std::string& id);

  const StudyOptions options_;
  StudyStore& store_;
  jobs::Scheduler& scheduler_;
  const intake::CaseIntake& intake_;
  StudyNotifier notifier_;
  Predictions predictions_;

  std::mutex requests_mutex_;  ///< serialises creation, resumption and removal
  std::mutex queueing_mutex_;  ///< makes giving a run its job atomic with its cancellation
  std::mutex files_mutex_;     ///< guards the study files
  jobs::Recent<const StudyPlan> plans_{32};               ///< by study
  jobs::Recent<const RunCurves> histories_{128'000'000};  ///< by job that has ended; bytes
  jobs::Recent<const RunFace> faces_{4096};               ///< by job that succeeded
  std::mutex feeder_mutex_;
  /// Wakes the feeder, as does the end of a job.
  std::condition_variable_any feeder_wake_;
  bool feeder_woken_ = true;
  std::map<std::string, int> unanswered_;  ///< checks of a run that crashed a worker
  std::jthread feeder_;
  SurfaceKeeper surface_keeper_;
};

}  // namespace dccast::studies
