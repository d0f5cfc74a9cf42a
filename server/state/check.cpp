#include "server/state/check.hpp"

#include <fmt/core.h>

#include <map>
#include <memory>
#include <optional>
#include <set>

#include "core/storage/file.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/logs/event_log_scan.hpp"
#include "server/state/index.hpp"
#include "server/studies/lines.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_plan.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// Finds a run by its jobs: the last attempt that has a row, unless the file of the study has a
/// later one.
studies::RunRecord find_run(const studies::StudyRecord& study, const studies::StudyPlan& plan,
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
    runs.push_back(find_run(record, *plan, number, kept, jobs));
    // In a plan that grows, the first run without a job waits: the daemon decides whether it is
    // needed.
    if (number + 1 >= plan->runs() && runs.back().job.empty()) break;
  }

  if (!store.insert(record, runs))
    throw std::runtime_error(
        fmt::format("its request_id \"{}\" belongs to another study", record.request.request_id()));
}

/// Checks a study that has a file but no row.
void check_lost_study(const StateFolder& folder, studies::StudyStore& store, jobs::JobStore& jobs,
                      const std::string& id, const CheckOptions& options, Report& report) {
  const std::string subject = fmt::format("study {}: ", id);
  if (!options.repair)
    return report.damage(subject + "it has no row; --repair makes it from its file");
  try {
    adopt_study(folder, store, jobs, id);
    report.repaired(subject + "its row is made again");
  } catch (const jobs::StoreError&) {
    throw;
  } catch (const std::runtime_error& error) {
    report.damage(subject + error.what());
  }
}

/// Checks the file of a study that has a row.
void check_study_file(const StateFolder& folder, studies::StudyStore& store, const std::string& id,
                      const CheckOptions& options, Report& report) {
  try {
    studies::read_study_file(folder.studies(), id);
  } catch (const std::runtime_error& error) {
    const std::string fault = fmt::format("study {}: {}", id, error.what());
    if (!options.repair) return report.note(fault + "; --repair writes it from the store");

    fs::create_directories(folder.studies());
    studies::write_study_file(folder.studies(), store.find(id).value());
    report.repaired(fault + "; written from the store");
  }
}

/// Checks all studies, after the rows of the jobs have been repaired.
void check_studies(const StateFolder& folder, jobs::JobStore& jobs, const CheckOptions& options,
                   Report& report) {
  studies::StudyStore store(folder.store());
  for (const std::string& id : lost_studies(folder))
    check_lost_study(folder, store, jobs, id, options, report);

  const auto ids = store.ids();
  for (const std::string& id : ids) check_study_file(folder, store, id, options, report);
  if (!ids.empty()) report.note(fmt::format("{} studies in the store", ids.size()));
}

/// Checks the lines, which nothing but their files describes.
void check_lines(const StateFolder& folder, Report& report) {
  const v1::ListLinesResponse found = studies::list_lines(folder.lines());
  for (const std::string& name : found.damaged())
    report.damage(fmt::format(
        "line {}: its file is damaged; restore it from a backup, or delete it and begin it again",
        name));
}

/// One inspection of a whole state folder.
class Check {
public:
  Check(const StateFolder& folder, const CheckOptions& options, std::ostream& out)
      : folder_(folder), options_(options), report_{out} {}

  int run() {
    check_store();
    if (store_)
      check_rows();
    else
      for (const std::string& id : jobs::folder_ids(folder_.jobs()))
        report_.note(fmt::format("job {}: {}", id, adoptability(folder_.jobs() / id)));

    if (!options_.index_only) {
      list_removals();
      list_quarantine();
    }
    return report_.damages;
  }

private:
  /// Checks all that has a row or should have one. The jobs come before the studies, whose runs are
  /// found by the rows of their jobs.
  void check_rows() {
    for (const std::string& id : options_.adopt) restore_from_quarantine(id);
    for (const std::string& id : jobs::folder_ids(folder_.jobs()))
      if (!ids_.contains(id)) check_unknown(id);
    if (!options_.index_only)
      for (const std::string& id : ids_) check_job(folder_, *store_, id, options_, report_);
    check_studies(folder_, *store_, options_, report_);
    if (!options_.index_only) check_lines(folder_, report_);
    report_totals();
  }

  /// Opens the store. It stays closed if it is damaged and repair is off.
  void check_store() {
    const std::string fault = open();
    if (fault.empty()) return;
    if (!options_.repair) return report_.damage(fault + "; --repair begins it again");

    report_.repaired(fmt::format("{}; its files are now in {}", fault, set_store_aside()));
    if (const std::string remaining = open(); !remaining.empty()) report_.damage(remaining);
  }

  /// Opens the store. @return its fault, in which case it is closed; empty for none
  std::string open() {
    try {
      const bool is_missing = storage::kind_of_entry(folder_.store()).empty();
      if (!options_.repair && is_missing) {  // opening it would create it
        if (jobs::folder_ids(folder_.jobs()).empty())
          throw std::runtime_error(
              fmt::format("there is no job store in {} and no job; nothing to "
                          "check",
                          folder_.path().string()));
        return fmt::format("the job store {} is missing", folder_.store().string());
      }

      store_ = std::make_unique<jobs::JobStore>(folder_.store());
      const std::string fault = store_->first_fault();
      ids_ = store_->ids();
      read_all_rows(folder_, *store_);
      if (fault.empty()) return {};

      store_.reset();
      return fmt::format("the job store {} is damaged: {}", folder_.store().string(), fault);
    } catch (const jobs::StoreError& error) {
      store_.reset();
      if (!jobs::must_be_rebuilt(error)) throw;
      return fmt::format("{} ({})", error.what(), folder_.store().string());
    }
  }

  /// Moves the files of the store to quarantine. @return their new directory
  std::string set_store_aside() {
    fs::create_directories(folder_.quarantine());
    const fs::path aside = jobs::free_name(folder_.quarantine() / "store");
    fs::create_directory(aside);
    for (const fs::path& file : {folder_.store(), folder_.wal(), folder_.shared_memory()})
      if (!storage::kind_of_entry(file).empty()) fs::rename(file, aside / file.filename());

    storage::sync_directory(aside);
    storage::sync_directory(folder_.quarantine());
    storage::sync_directory(folder_.path());
    return aside.string();
  }

  static std::string adoptability(const fs::path& folder) {
    try {
      jobs::read_job_description(folder);
      return jobs::was_accepted(folder) ? "its row can be made again from its folder"
                                        : "it was never acknowledged";
    } catch (const std::exception& error) {
      return fmt::format("its row cannot be made again: {}", error.what());
    }
  }

  void restore_from_quarantine(const std::string& id) {
    const std::string subject = fmt::format("job {}: ", id);
    if (ids_.contains(id)) return report_.note(subject + "the store has it already");

    const bool was_in_jobs = fs::exists(folder_.jobs() / id);
    if (!was_in_jobs && !jobs::release_folder(folder_.jobs(), id))
      return report_.damage(subject + "there is no such folder in quarantine");
    if (!adopt_folder(id)) jobs::quarantine_folder(folder_.jobs(), id);
  }

  /// @return whether the store has the job now
  bool adopt_folder(const std::string& id) {
    try {
      index_job(*store_, folder_.jobs() / id);
    } catch (const jobs::StoreError&) {
      throw;
    } catch (const std::runtime_error& error) {
      report_.damage(fmt::format("job {}: it cannot be taken back: {}", id, error.what()));
      return false;
    }

    ids_.insert(id);
    report_.repaired(fmt::format("job {}: taken back into the store as {}", id,
                                 v1::JobState_Name(store_->find(id)->job.state())));
    return true;
  }

  /// Checks a folder of `jobs/` whose job has no row.
  void check_unknown(const std::string& id) {
    const std::string subject = fmt::format("job {}: ", id);
    if (!jobs::was_accepted(folder_.jobs() / id)) {
      if (!options_.repair)
        return report_.note(subject +
                            "it was never acknowledged; the next start moves it to quarantine");

      const fs::path aside = jobs::quarantine_folder(folder_.jobs(), id);
      return report_.repaired(subject + "it was never acknowledged; moved to " + aside.string());
    }

    if (!options_.repair)
      return report_.damage(subject + "it has no row; " + adoptability(folder_.jobs() / id));
    if (!adopt_folder(id))
      report_.note(subject + "moved to " + jobs::quarantine_folder(folder_.jobs(), id).string());
  }

  void report_totals() {
    if (report_.with_leftovers > 0)
      report_.note(fmt::format("checkpoints and journals of {} ended jobs: {} bytes{}",
                               report_.with_leftovers, report_.leftover_bytes,
                               options_.repair ? ", deleted" : "; --repair deletes them"));
    report_.note(fmt::format("{} jobs in the store", ids_.size()));
  }

  void list_removals() {
    if (!fs::exists(folder_.jobs())) return;
    for (const auto& entry : fs::directory_iterator(folder_.jobs()))
      if (entry.path().extension() == ".removed")
        report_.note(fmt::format("{}: an interrupted deletion; the next start completes it",
                                 entry.path().string()));
  }

  void list_quarantine() {
    for (const auto& [id, path] : jobs::quarantined_folders(folder_.jobs())) {
      const std::string remedy =
          ids_.contains(id) ? "the store has a job of this id" : fmt::format("--adopt {}", id);
      report_.note(
          fmt::format("quarantine: {}: {}; {}", path.string(), adoptability(path), remedy));
    }
  }

  const StateFolder& folder_;
  const CheckOptions& options_;
  Report report_;
  std::unique_ptr<jobs::JobStore> store_;
  std::set<std::string> ids_;
};

/// Repairs are refused while a worker runs: it writes into the folder of its job, and the next
/// daemon adopts it with the store and the event log as they are now.
void require_no_worker(const StateFolder& folder) {
  for (const std::string& id : jobs::folder_ids(folder.jobs()))
    if (const auto worker = jobs::find_holder(folder.jobs() / id))
      throw std::runtime_error(
          fmt::format("job {} still runs in process {}; start dccastd, which continues it, or end "
                      "that process first",
                      id, worker->process));
}

}  // namespace

void rebuild_index(const StateFolder& folder, std::ostream& out) {
  const CheckOptions options{.repair = true, .deep = false, .adopt = {}, .index_only = true};
  Check(folder, options, out).run();
}

int check(const StateFolder& folder, const CheckOptions& options, std::ostream& out) {
  if (!fs::is_directory(folder.path()))
    throw std::runtime_error(fmt::format("there is no data directory {}", folder.path().string()));

  const StateLock lock(folder);
  require_data_format(folder);
  const bool writes = options.repair || !options.adopt.empty();
  if (writes) require_no_worker(folder);
  const int damages = Check(folder, options, out).run();
  out << (damages == 0 ? "sound" : fmt::format("{} damages left", damages)) << std::endl;
  return damages;
}

}  // namespace dccast::state
