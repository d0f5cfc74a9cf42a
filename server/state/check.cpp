#include "server/state/check.hpp"

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
#include "server/studies/study_file.hpp"
#include "server/studies/study_plan.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

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

/// The rows of jobs are sound by then.
void check_studies(const StateFolder& folder, jobs::JobStore& jobs, const CheckOptions& options,
                   Report& report) {
  studies::StudyStore store(folder.store());
  for (const std::string& id : lost_studies(folder))
    check_lost(folder, store, jobs, id, options.repair, report);
  const auto ids = store.ids();
  for (const std::string& id : ids) check_file(folder, store, id, options.repair, report);
  if (!ids.empty()) report.note(std::to_string(ids.size()) + " studies in the store");
}

/// One inspection of a whole state folder.
class Check {
public:
  Check(const StateFolder& folder, const CheckOptions& options, std::ostream& out)
      : folder_(folder), options_(options), report_{out} {}

  int run() {
    check_store();
    std::optional<jobs::JobStore::Bulk> bulk;
    if (store_ && options_.index_only) bulk.emplace(*store_);
    if (store_ == nullptr) {
      for (const std::string& id : jobs::folder_ids(folder_.jobs()))
        report_.note("job " + id + ": " + adoptability(folder_.jobs() / id));
    } else {
      for (const std::string& id : options_.adopt) take_back(id);
      for (const std::string& id : jobs::folder_ids(folder_.jobs()))
        if (!ids_.contains(id)) check_unknown(id);
      for (const std::string& id : ids_) check_job(folder_, *store_, id, options_, report_);
      check_studies(folder_, *store_, options_, report_);
      report_totals();
    }
    if (!options_.index_only) {
      list_removals();
      list_quarantine();
    }
    return report_.damages;
  }

private:
  /// Opens the store, or leaves it closed when it is damaged and not to be repaired.
  void check_store() {
    const std::string fault = open();
    if (fault.empty()) return;
    if (!options_.repair) return report_.damage(fault + "; --repair begins it again");
    keep_requests();
    report_.repaired(fault + "; its files are now in " + set_store_aside());
    if (const std::string still = open(); !still.empty()) report_.damage(still);
  }

  /// Before version 7 a request to stop stood in the store alone; now it stands in the folder.
  void keep_requests() const try {
    constexpr std::int64_t last_with_requests = 6;
    if (!fs::exists(folder_.store())) return;
    jobs::Database store(folder_.store());
    jobs::Statement version(store, "PRAGMA user_version");
    if (!version.step() || version.integer(0) == 0 || version.integer(0) > last_with_requests)
      return;
    jobs::Statement requests(store, "SELECT id, wish, wish_reason FROM job WHERE wish <> 0");
    while (requests.step()) {
      const fs::path of_job = folder_.jobs() / requests.text(0);
      if (!fs::exists(of_job) || jobs::read_request(of_job)) continue;
      const auto action = static_cast<jobs::RequestedAction>(requests.integer(1));
      jobs::write_request(of_job, {action, requests.text(2)});
    }
  } catch (const jobs::StoreError&) {
    // It is damaged, or of a version that has them in the folders.
  }

  /// @return what is wrong with the store; it is closed then
  std::string open() {
    try {
      const bool is_missing = storage::kind_of_entry(folder_.store()).empty();
      if (!options_.repair && is_missing) {  // a check makes none
        if (jobs::folder_ids(folder_.jobs()).empty())
          throw std::runtime_error("there is no job store in " + folder_.path().string() +
                                   " and no job; nothing to check");
        return "the job store " + folder_.store().string() + " is missing";
      }
      store_ = std::make_unique<jobs::JobStore>(folder_.store());
      std::string fault = store_->first_fault();
      ids_ = store_->ids();
      if (fault.empty()) return {};
      store_.reset();
      return "the job store " + folder_.store().string() + " is damaged: " + fault;
    } catch (const jobs::StoreError& error) {
      store_.reset();
      if (!jobs::must_be_built_again(error)) throw;
      return std::string(error.what()) + " (" + folder_.store().string() + ")";
    }
  }

  /// Moves the files of the store to quarantine. @return where
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
      return std::string("its row cannot be made again: ") + error.what();
    }
  }

  void take_back(const std::string& id) {
    const std::string subject = "job " + id + ": ";
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
      report_.damage("job " + id + ": it cannot be taken back: " + error.what());
      return false;
    }
    ids_.insert(id);
    report_.repaired("job " + id + ": taken back into the store as " +
                     v1::JobState_Name(store_->find(id)->job.state()));
    return true;
  }

  void check_unknown(const std::string& id) {
    const std::string subject = "job " + id + ": ";
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
      report_.note("checkpoints and journals of " + std::to_string(report_.with_leftovers) +
                   " ended jobs: " + std::to_string(report_.leftover_bytes) + " bytes" +
                   (options_.repair ? ", deleted" : "; --repair deletes them"));
    report_.note(std::to_string(ids_.size()) + " jobs in the store");
  }

  void list_removals() {
    if (!fs::exists(folder_.jobs())) return;
    for (const auto& entry : fs::directory_iterator(folder_.jobs()))
      if (entry.path().extension() == ".removed")
        report_.note(entry.path().string() +
                     ": a deletion that was cut short; the next start ends it");
  }

  void list_quarantine() {
    for (const auto& [id, path] : jobs::quarantined_folders(folder_.jobs()))
      report_.note("quarantine: " + path.string() + ": " + adoptability(path) +
                   (ids_.contains(id) ? "; the store has a job of this id" : "; --adopt " + id));
  }

  const StateFolder& folder_;
  const CheckOptions& options_;
  Report report_;
  std::unique_ptr<jobs::JobStore> store_;
  std::set<std::string> ids_;
};

/// A worker that outlives its daemon writes into the folder of its job, and the next daemon goes on
/// with it as the store and the event log are now.
void require_no_worker(const StateFolder& folder) {
  for (const std::string& id : jobs::folder_ids(folder.jobs()))
    if (const auto worker = jobs::find_holder(folder.jobs() / id))
      throw std::runtime_error("job " + id + " still runs in process " +
                               std::to_string(worker->process) +
                               "; start dccastd, which goes on with it, or end that process first");
}

}  // namespace

void rebuild_index(const StateFolder& folder, std::ostream& out) {
  const CheckOptions options{.repair = true, .deep = false, .adopt = {}, .index_only = true};
  Check(folder, options, out).run();
}

int check(const StateFolder& folder, const CheckOptions& options, std::ostream& out) {
  if (!fs::is_directory(folder.path()))
    throw std::runtime_error("there is no data directory " + folder.path().string());
  const StateLock lock(folder);
  if (options.repair || !options.adopt.empty()) require_no_worker(folder);
  const int damages = Check(folder, options, out).run();
  out << (damages == 0 ? "sound" : std::to_string(damages) + " damages left") << std::endl;
  return damages;
}

}  // namespace dccast::state
