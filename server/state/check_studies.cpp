// What `dccastd check` looks at in studies: a row for every file, and a file for every row.
#include <algorithm>
#include <map>
#include <vector>

#include "server/state/check.hpp"
#include "server/state/index.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_plan.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

/// The run as its jobs show it: the last attempt that has a row stands for it, unless the file of
/// the study has something later.
studies::RunRecord run_of(const studies::StudyRecord& study, const studies::StudyPlan& plan,
                          int number, const std::map<int, studies::RunRecord>& kept,
                          jobs::JobStore& jobs) {
  studies::RunRecord run;
  run.number = number;
  const std::string key = plan.key(number);
  while (const auto job =
             jobs.find_request(studies::job_request_id(study.id, key, run.attempt + 1))) {
    run.job = job->job.id();
    ++run.attempt;
  }
  const auto found = kept.find(number);
  return found != kept.end() && found->second.attempt >= run.attempt ? found->second : run;
}

/// Makes the row of a study from its file and its jobs. @throws std::runtime_error
void adopt_study(const StateFolder& folder, studies::StudyStore& store, jobs::JobStore& jobs,
                 const std::string& id) {
  const studies::StudyRecord record = studies::read_study_file(folder.studies(), id);
  const auto kept = studies::read_study_runs(folder.studies(), id);
  const auto plan = studies::study_plan(record.request);
  std::vector<studies::RunRecord> runs;
  for (int number = 0; number < plan->most_runs(); ++number) {
    runs.push_back(run_of(record, *plan, number, kept, jobs));
    // Of a plan that grows the first run without a job waits; the daemon decides whether it is
    // needed.
    if (number + 1 >= plan->runs() && runs.back().job.empty()) break;
  }
  if (!store.insert(record, runs))
    throw std::runtime_error("its request_id \"" + record.request.request_id() +
                             "\" belongs to another study");
}

void check_lost(const StateFolder& folder, studies::StudyStore& store, jobs::JobStore& jobs,
                const std::string& id, bool repair, Report& report) {
  const std::string subject = "study " + id + ": ";
  if (!repair) return report.damage(subject + "it has no row; --repair makes it from its file");
  try {
    adopt_study(folder, store, jobs, id);
    report.repaired(subject + "its row is made again");
  } catch (const jobs::StoreError&) {
    throw;
  } catch (const std::runtime_error& error) {
    report.damage(subject + error.what());
  }
}

void check_file(const StateFolder& folder, studies::StudyStore& store, const std::string& id,
                bool repair, Report& report) {
  try {
    studies::read_study_file(folder.studies(), id);
  } catch (const std::runtime_error& error) {
    const std::string what = "study " + id + ": " + error.what();
    if (!repair) return report.note(what + "; --repair writes it from the store");
    std::filesystem::create_directories(folder.studies());
    studies::write_study_file(folder.studies(), store.find(id).value());
    report.repaired(what + "; written from the store");
  }
}

}  // namespace

void check_studies(const StateFolder& folder, jobs::JobStore& jobs, const CheckOptions& options,
                   Report& report) {
  studies::StudyStore store(folder.store());
  for (const std::string& id : lost_studies(folder))
    check_lost(folder, store, jobs, id, options.repair, report);
  const auto ids = store.ids();
  for (const std::string& id : ids) check_file(folder, store, id, options.repair, report);
  if (!ids.empty()) report.note(std::to_string(ids.size()) + " studies in the store");
}

}  // namespace dccast::state
