#include "server/studies/studies_state.hpp"

#include <climits>
#include <utility>

namespace dccast::studies {

StudiesState::StudiesState(StudyOptions study_options, StudyStore& study_store,
                           jobs::Scheduler& of_jobs, const intake::CaseIntake& of_cases)
    : options(std::move(study_options)), store(study_store), scheduler(of_jobs), intake(of_cases) {}

std::shared_ptr<const StudyPlan> StudiesState::plan_of(const StudyRecord& study) {
  if (const auto kept = plans.find(study.id)) return kept;
  return plans.keep(study.id, study_plan(study.request));
}

std::map<std::string, v1::Job> StudiesState::jobs_of(const StudyRecord& study) {
  std::map<std::string, v1::Job> jobs;
  for (v1::Job& job : scheduler.list({.study = study.id, .size = INT_MAX}))
    if (job.owner() == study.owner) jobs[job.id()] = std::move(job);
  return jobs;
}

std::vector<RunAndJob> StudiesState::runs_and_jobs(const StudyRecord& study) {
  // The runs first: the feeder may queue a run in between, whose job an older list would lack.
  std::vector<RunRecord> runs = store.runs(study.id);
  auto jobs = jobs_of(study);

  std::vector<RunAndJob> joined;
  for (RunRecord& run : runs) {
    std::optional<v1::Job> job;
    if (const auto found = jobs.find(run.job); found != jobs.end()) job = std::move(found->second);
    joined.push_back({std::move(run), std::move(job)});
  }
  return joined;
}

void StudiesState::write_file(const StudyRecord& study) {
  const std::lock_guard lock(files_mutex_);
  write_study_file(options.directory, study);
}

void StudiesState::append_to_file(const StudyRecord& study, const std::vector<RunRecord>& runs) {
  const std::lock_guard lock(files_mutex_);
  if (!std::filesystem::exists(study_file(options.directory, study.id)))
    write_study_file(options.directory, study);
  append_runs(options.directory, study.id, runs);
}

void StudiesState::note_change(const std::string& id) {
  notifier.note(id);
  surface_keeper.look_at(id);
}

}  // namespace dccast::studies
