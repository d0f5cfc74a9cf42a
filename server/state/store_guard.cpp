#include "server/state/store_guard.hpp"

#include "server/jobs/log.hpp"

#include <sstream>

#include "server/jobs/event_log_scan.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/jobs/worker_claim.hpp"
#include "server/state/adoption.hpp"
#include "server/state/check.hpp"
#include "server/state/wal_file.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// A store beyond this size is held against itself by `dccastd check` only, so that the daemon
/// starts soon. 10,000 jobs in 90 MB take 0.06 s of processor time.
constexpr std::uintmax_t largest_store_to_check = 512u << 20;  // [bytes]

/// What a row and the description in the job's folder do not agree on; empty for nothing.
std::string described_otherwise(jobs::JobStore& store, const jobs::JobRecord& record,
                                const fs::path& folder) {
  try {
    return contradiction(store, record, jobs::read_job_description(folder));
  } catch (const jobs::StoreError&) {
    throw;
  } catch (const std::runtime_error& error) {
    spdlog::warn("job {}: {}", record.job.id(), error.what());
    return "description";  // it is written again from the row
  }
}

/// A crash can come between the row and the mark, and who submitted the job learn of the row by
/// submitting it again.
void mark_as_accepted(const StateFolder& folder, const jobs::JobRecord& record) {
  const fs::path of_job = folder.jobs() / record.job.id();
  if (fs::exists(of_job) && !jobs::was_accepted(of_job)) jobs::mark_accepted(of_job);
}

/// A job whose row has ended while its folder is claimed as that of a run which has not. A claim goes
/// when the end of a job has been written. @return its id; empty for none
std::string contradicted_by_worker(const StateFolder& folder, jobs::JobStore& store) {
  for (const std::string& id : jobs::folder_ids(folder.jobs())) {
    if (!jobs::last_sign_of_life(folder.jobs() / id)) continue;
    const auto record = store.find(id);
    if (record && jobs::is_terminal(record->job.state()) &&
        !jobs::scan_event_log(folder.jobs() / id / "events.log").terminal)
      return id;
  }
  return {};
}

/// Why the store cannot be the index of the folders; empty for none.
std::string why_in_doubt(const StateFolder& folder, jobs::JobStore& store) {
  if (const auto lost = lost_jobs(folder, store.ids()); !lost.empty())
    return std::to_string(lost.size()) + " jobs that were acknowledged are missing, e.g. " +
           *lost.begin();
  if (const auto lost = lost_studies(folder); !lost.empty())
    return std::to_string(lost.size()) + " studies are missing, e.g. " + *lost.begin();
  if (const std::string id = contradicted_by_worker(folder, store); !id.empty())
    return "it says that job " + id + " has ended, which its folder does not";
  for (const jobs::JobRecord& record : store.unfinished()) {
    const fs::path of_job = folder.jobs() / record.job.id();
    if (!fs::exists(of_job)) continue;  // `dccastd check` reports it
    if (const std::string field = described_otherwise(store, record, of_job); !field.empty())
      return "the " + field + " of job " + record.job.id() +
             " is not the one it was submitted with";
  }
  return {};
}

/// Opens the store and looks whether it can be the index. @return why not; empty for no reason
std::string open_and_doubt(const StateFolder& folder, std::unique_ptr<jobs::JobStore>& store) {
  if (std::string fault = store_file_fault(folder); !fault.empty()) return fault;
  keep_damaged_wal(folder);
  try {
    store = std::make_unique<jobs::JobStore>(folder.store());
    if (fs::file_size(folder.store()) <= largest_store_to_check)
      if (const std::string fault = store->first_fault(); !fault.empty())
        return "it is damaged: " + fault;
    return why_in_doubt(folder, *store);
  } catch (const jobs::StoreError& error) {
    if (!jobs::is_damage(error)) throw;
    return error.what();
  }
}

}  // namespace

std::string store_file_fault(const StateFolder& folder) {
  const std::size_t folders = jobs::folder_ids(folder.jobs()).size();
  const std::string beside = ", but there are " + std::to_string(folders) + " job folders";
  if (folders > 0 && !fs::exists(folder.store()))
    return "the job store " + folder.store().string() + " is missing" + beside;
  if (folders > 0 && fs::file_size(folder.store()) == 0 &&
      inspect_wal(folder.wal()) == WalState::empty)
    return "the job store " + folder.store().string() + " is empty" + beside;
  if (inspect_wal(folder.wal()) == WalState::damaged_header)
    return "the write-ahead log of the job store, " + folder.wal().string() + ", is damaged";
  return {};
}

std::set<std::string> lost_jobs(const StateFolder& folder, const std::set<std::string>& known_ids) {
  std::set<std::string> lost;
  for (const std::string& id : jobs::folder_ids(folder.jobs()))
    if (!known_ids.contains(id) && jobs::was_accepted(folder.jobs() / id)) lost.insert(id);
  return lost;
}

std::set<std::string> lost_studies(const StateFolder& folder) {
  std::set<std::string> lost = studies::ids_of_study_files(folder.studies());
  if (lost.empty()) return lost;
  studies::StudyStore store(folder.store());
  for (const std::string& id : store.ids()) lost.erase(id);
  for (const std::string& id : store.removing()) lost.erase(id);
  return lost;
}

void keep_damaged_wal(const StateFolder& folder) {
  if (inspect_wal(folder.wal()) != WalState::damaged_frames) return;
  const fs::path copy = folder.wal().string() + ".damaged";
  fs::copy_file(folder.wal(), copy, fs::copy_options::overwrite_existing);
  spdlog::warn(
      "{}: a record in the middle is damaged, so what was written after it is lost; copied "
      "to {}",
      folder.wal().string(), copy.string());
}

std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder) {
  std::unique_ptr<jobs::JobStore> store;
  if (const std::string doubt = open_and_doubt(folder, store); !doubt.empty()) {
    store.reset();
    spdlog::warn("{}: {}; it is built again from the folders of the jobs", folder.store().string(),
                 doubt);
    std::ostringstream report;
    rebuild_index(folder, report);
    spdlog::warn("what was done:\n{}", report.str());
    store = std::make_unique<jobs::JobStore>(folder.store());
  }
  for (const jobs::JobRecord& record : store->unfinished()) mark_as_accepted(folder, record);
  return store;
}

}  // namespace dccast::state
