#include "server/state/store_guard.hpp"

#include "server/jobs/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/quarantine.hpp"
#include "server/state/adoption.hpp"
#include "server/state/wal_file.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// A store beyond this size is held against itself by `dccastd check` only, so that the daemon
/// starts soon. 10,000 jobs in 90 MB take 0.06 s of processor time.
constexpr std::uintmax_t largest_store_to_check = 512u << 20;  // [bytes]

[[noreturn]] void refuse(const StateFolder& folder, const std::string& what) {
  throw StoreLost(what + "; " + repair_remedy(folder));
}

/// A description that is damaged itself says nothing about the row; `dccastd check` tells it.
std::string described_otherwise(jobs::JobStore& store, const jobs::JobRecord& record,
                                const fs::path& folder) {
  try {
    return contradiction(store, record, jobs::read_job_description(folder));
  } catch (const jobs::StoreError&) {
    throw;
  } catch (const std::runtime_error& error) {
    spdlog::warn("job {}: {}", record.job.id(), error.what());
    return {};
  }
}

/// A job that is yet to run must run the case it was submitted with.
void require_case_as_submitted(const StateFolder& folder, jobs::JobStore& store,
                               const jobs::JobRecord& record) {
  const fs::path of_job = folder.jobs() / record.job.id();
  if (!fs::exists(of_job / jobs::description_file)) return;
  const std::string field = described_otherwise(store, record, of_job);
  if (field.empty()) return;
  refuse(folder, "the row of job " + record.job.id() + " in the job store is damaged: its " +
                     field + " is not the one the job was submitted with");
}

/// A crash can come between the row and the mark, and who submitted it hear of the row on asking
/// again.
void mark_as_accepted(const StateFolder& folder, const jobs::JobRecord& record) {
  const fs::path of_job = folder.jobs() / record.job.id();
  if (fs::exists(of_job) && !jobs::was_accepted(of_job)) jobs::mark_accepted(of_job);
}

std::unique_ptr<jobs::JobStore> open_sound(const StateFolder& folder) {
  auto store = std::make_unique<jobs::JobStore>(folder.store());
  if (fs::file_size(folder.store()) > largest_store_to_check) return store;
  const std::string fault = store->first_fault();
  if (fault.empty()) return store;
  spdlog::error("{}: {}", folder.store().string(), fault);
  refuse(folder, "the job store " + folder.store().string() + " is damaged");
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
  if (const std::string fault = store_file_fault(folder); !fault.empty()) refuse(folder, fault);
  keep_damaged_wal(folder);
  try {
    auto store = open_sound(folder);
    const auto lost = lost_jobs(folder, store->ids());
    if (!lost.empty())
      refuse(folder, "the job store " + folder.store().string() + " has lost " +
                         std::to_string(lost.size()) + " jobs that were acknowledged, e.g. " +
                         *lost.begin());
    const auto studies = lost_studies(folder);
    if (!studies.empty())
      refuse(folder, "the job store " + folder.store().string() + " has lost " +
                         std::to_string(studies.size()) + " studies, e.g. " + *studies.begin());
    for (const jobs::JobRecord& record : store->unfinished()) {
      require_case_as_submitted(folder, *store, record);
      mark_as_accepted(folder, record);
    }
    return store;
  } catch (const jobs::StoreError& error) {
    if (!jobs::is_damage(error)) throw;
    refuse(folder, std::string(error.what()) + " (" + folder.store().string() + ")");
  }
}

}  // namespace dccast::state
