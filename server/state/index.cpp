#include "server/state/index.hpp"

#include <fmt/core.h>

#include <sstream>

#include "core/storage/file.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/event_log_scan.hpp"
#include "server/jobs/logs/stored_job.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// A larger store is verified by `dccastd check` only, so that the daemon starts quickly. 10,000
/// jobs in 90 MB take 0.06 s of processor time.
constexpr std::uintmax_t largest_store_to_check = 512u << 20;  // [bytes]

/// Does something with a job. A folder that cannot be read keeps no other from being indexed: its
/// start fails with the reason, and `dccastd check` names it.
template <class Action>
void try_with(const std::string& id, const Action& action) {
  try {
    action();
  } catch (const jobs::StoreError&) {
    throw;
  } catch (const std::exception& error) {
    log::error("job {}: {}", id, error.what());
  }
}

/// Makes the rows of acknowledged jobs that have none.
void add_lost(const StateFolder& folder, jobs::JobStore& store) {
  const auto lost = lost_jobs(folder, store.ids());
  if (lost.empty()) return;

  log::warn("the store lacks {} jobs, e.g. {}; their rows are built again from the folders",
            lost.size(), *lost.begin());
  for (const std::string& id : lost) try_with(id, [&] { index_job(store, folder.jobs() / id); });
}

/// Opens the store and checks whether it can be the index. @return why not; empty if it can
std::string open_and_doubt(const StateFolder& folder, std::unique_ptr<jobs::JobStore>& store) {
  try {
    store = std::make_unique<jobs::JobStore>(folder.store());
    if (fs::file_size(folder.store()) <= largest_store_to_check)
      if (const std::string fault = store->first_fault(); !fault.empty())
        return fmt::format("it is damaged: {}", fault);
    read_all_rows(folder, *store);
    if (const auto lost = lost_studies(folder); !lost.empty())
      return fmt::format("{} studies are missing, e.g. {}", lost.size(), *lost.begin());
    return {};
  } catch (const jobs::StoreError& error) {
    if (!jobs::must_be_rebuilt(error)) throw;
    return error.what();
  }
}

/// Whether the row of a job is as its folder is now. The folder of a job that has ended changes in
/// its marks alone, unless its claim shows that a worker goes on there.
bool is_current(const jobs::JobRecord& row, const fs::path& job_folder) {
  v1::Job marked = row.job;
  jobs::read_marks(job_folder, marked);
  if (marked.SerializeAsString() != row.job.SerializeAsString()) return false;

  if (!jobs::is_terminal(row.job.state()))
    return row.sequence >= jobs::last_state_sequence(job_folder);
  return jobs::signs_in(job_folder).claimed_ns == 0 ||
         row.sequence == jobs::last_state_sequence(job_folder);
}

/// Makes rows that are older than their folders again.
void update_rows(const StateFolder& folder, jobs::JobStore& store) {
  for (const jobs::JobRecord& row : store.list({.size = jobs::JobStore::Page::all})) {
    const fs::path job_folder = folder.jobs() / row.job.id();
    if (!fs::exists(job_folder)) continue;  // `dccastd check` reports it

    try_with(row.job.id(), [&] {
      // After a crash between row and mark, a repeated submission is answered with the row, so the
      // job counts as acknowledged.
      if (!jobs::was_accepted(job_folder)) jobs::mark_accepted(job_folder);
      if (is_current(row, job_folder)) return;

      log::warn("job {}: its row is older than its folder and is made again", row.job.id());
      index_job(store, job_folder);
    });
  }
}

}  // namespace

void read_all_rows(const StateFolder& folder, jobs::JobStore& store) {
  store.list({.size = jobs::JobStore::Page::all});
  studies::StudyStore(folder.store()).list({.size = jobs::JobStore::Page::all});
}

void index_job(jobs::JobStore& store, const fs::path& folder) {
  const jobs::JobRecord record = jobs::read_job(folder);
  const auto other = store.find_request(record.job.request_id());
  if (other && other->job.id() != record.job.id())
    throw std::runtime_error(fmt::format("its request_id \"{}\" belongs to job {}",
                                         record.job.request_id(), other->job.id()));

  store.put(record);
  if (!jobs::was_accepted(folder)) jobs::mark_accepted(folder);
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
  for (const studies::StudyRecord& study : store.removing()) lost.erase(study.id);
  return lost;
}

std::unique_ptr<jobs::JobStore> open_store(const StateFolder& folder) {
  require_data_format(folder);

  std::unique_ptr<jobs::JobStore> store;
  if (const std::string doubt = open_and_doubt(folder, store); !doubt.empty()) {
    store.reset();
    log::warn("{}: {}; it is built again from the folders of the jobs", folder.store().string(),
              doubt);

    std::ostringstream report;
    rebuild_index(folder, report);
    log::warn("the store was rebuilt:\n{}", report.str());
    store = std::make_unique<jobs::JobStore>(folder.store());
  }

  add_lost(folder, *store);
  update_rows(folder, *store);
  return store;
}

}  // namespace dccast::state
