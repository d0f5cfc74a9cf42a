#include "server/state/index.hpp"

#include <fmt/core.h>

#include <sstream>

#include "core/storage/file.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/logs/event_log_scan.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_store.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// A larger store is verified by `dccastd check` only, so that the daemon starts quickly. 10,000
/// jobs in 90 MB take 0.06 s of processor time.
constexpr std::uintmax_t largest_store_to_check = 512u << 20;  // [bytes]

/// Size of a submission, as the scheduler counts it [bytes].
std::int64_t submission_bytes(const fs::path& folder, const jobs::JobDescription& description) {
  auto bytes = description.submitted_case.size() + description.complete_case.size();
  if (fs::exists(folder / jobs::attachments_folder))
    for (const auto& file : fs::directory_iterator(folder / jobs::attachments_folder))
      bytes += file.file_size();
  return static_cast<std::int64_t>(bytes);
}

/// Sets state, attempts, times, failure and artifacts of a record from its event log.
void apply_log(const fs::path& path, jobs::JobRecord& record) {
  const jobs::EventLog log(path);
  const jobs::EventLogContent content = log.content();

  v1::Job& job = record.job;
  job.set_attempts(content.attempts);
  if (content.started) *job.mutable_start_time() = *content.started;
  log.complete(job);

  if (!content.last_state) return;

  const v1::JobEvent::StateChange& change = *content.last_state;
  job.set_state(change.state());
  record.losses = change.losses().times();
  record.lost_step = change.has_losses() ? change.losses().last_step() : -1;
  record.first_loss = change.losses().first_cause();
  record.solver = change.solver();

  if (!change.terminal()) return;

  if (content.terminal) *job.mutable_end_time() = content.terminal->time();
  if (change.has_failure()) *job.mutable_failure() = change.failure();
  *job.mutable_artifacts() = change.artifacts();
  record.bytes = jobs::bytes_kept(path.parent_path());
}

/// Scans an event log; anything but a regular file counts as empty.
jobs::EventLogContent scan_if_file(const fs::path& log) {
  const bool is_file = storage::kind_of_entry(log) == storage::regular_file;
  return is_file ? jobs::scan_event_log(log) : jobs::EventLogContent{};
}

/// Whether a job has an event log. A lost log can be begun again only if no other file shows that
/// the job has run. @throws std::runtime_error  another file does
bool has_history(const fs::path& folder) {
  const fs::path log = folder / "events.log";
  const bool is_there = !storage::kind_of_entry(log).empty();
  if (is_there && scan_if_file(log).last_sequence > 0) return true;

  if (fs::exists(folder / "results.h5"))
    throw std::runtime_error("its events.log is lost, and it has results of an unknown attempt");
  if (is_there && fs::exists(folder / "worker.log"))
    throw std::runtime_error("its events.log has no event that can be read, and it has run");
  return false;
}

/// Finds a job whose row has ended although a worker has claimed its folder and the run has not
/// ended. A claim is removed after the end of a job. @return its id; empty for none
std::string find_contradicted_row(const StateFolder& folder, jobs::JobStore& store) {
  for (const std::string& id : jobs::folder_ids(folder.jobs())) {
    if (jobs::signs_in(folder.jobs() / id).claimed_ns == 0) continue;
    const auto record = store.find(id);
    const bool has_ended = record && jobs::is_terminal(record->job.state());
    if (has_ended && !scan_if_file(folder.jobs() / id / "events.log").terminal) return id;
  }
  return {};
}

/// Why the store cannot be the index of the folders; empty if it can.
std::string find_doubt(const StateFolder& folder, jobs::JobStore& store) {
  if (const auto lost = lost_jobs(folder, store.ids()); !lost.empty())
    return fmt::format("{} jobs that were acknowledged are missing, e.g. {}", lost.size(),
                       *lost.begin());
  if (const auto lost = lost_studies(folder); !lost.empty())
    return fmt::format("{} studies are missing, e.g. {}", lost.size(), *lost.begin());
  if (const std::string id = find_contradicted_row(folder, store); !id.empty())
    return fmt::format("it has job {} as ended, its folder has not", id);
  return {};
}

/// Opens the store and checks whether it can be the index. @return why not; empty if it can
std::string open_and_doubt(const StateFolder& folder, std::unique_ptr<jobs::JobStore>& store) {
  try {
    store = std::make_unique<jobs::JobStore>(folder.store());
    if (fs::file_size(folder.store()) <= largest_store_to_check)
      if (const std::string fault = store->first_fault(); !fault.empty())
        return fmt::format("it is damaged: {}", fault);
    return find_doubt(folder, *store);
  } catch (const jobs::StoreError& error) {
    if (!jobs::must_be_rebuilt(error)) throw;
    return error.what();
  }
}

/// Repairs the rows of jobs that have not ended, because a wrong one would be run.
void update_unfinished(const StateFolder& folder, jobs::JobStore& store) {
  const jobs::JobStore::Bulk bulk(store);
  for (const jobs::JobRecord& row : store.unfinished()) {
    const fs::path job_folder = folder.jobs() / row.job.id();
    if (!fs::exists(job_folder)) continue;  // `dccastd check` reports it

    // After a crash between row and mark, a repeated submission is answered with the row, so the
    // job counts as acknowledged.
    if (!jobs::was_accepted(job_folder)) jobs::mark_accepted(job_folder);

    try {
      if (agrees(row, described_job(job_folder))) continue;
      log::warn("job {}: its row differs from its folder and is rebuilt", row.job.id());
      index_job(store, job_folder);
    } catch (const jobs::StoreError&) {
      throw;
    } catch (const std::exception& error) {
      log::error("job {}: {}", row.job.id(), error.what());  // its start fails with that reason
    }
  }
}

}  // namespace

jobs::JobRecord described_job(const fs::path& folder) {
  const jobs::JobDescription description = jobs::read_job_description(folder);
  if (description.job.id() != folder.filename())
    throw std::runtime_error(fmt::format("it describes another job, {}", description.job.id()));

  jobs::JobRecord record;
  record.job = description.job;
  record.job.set_state(v1::QUEUED);
  jobs::read_marks(folder, record.job);
  record.answer_key = description.answer_key;
  record.bytes = submission_bytes(folder, description);
  return record;
}

bool agrees(const jobs::JobRecord& row, const jobs::JobRecord& described) {
  // The fields of the description. The others change during the life of a job.
  const auto description = [](const jobs::JobRecord& record) {
    v1::Job job = record.job;
    *job.mutable_create_time() = jobs::timestamp(jobs::milliseconds(job.create_time()));
    for (const char* field : {"state", "start_time", "end_time", "last_step", "findings",
                              "validity_loss", "failure", "artifacts", "attempts", "run_s"})
      job.GetReflection()->ClearField(&job, v1::Job::descriptor()->FindFieldByName(field));
    return job.SerializeAsString() + record.answer_key;
  };
  return description(row) == description(described);
}

void index_job(jobs::JobStore& store, const fs::path& folder) {
  jobs::JobRecord record = described_job(folder);
  if (has_history(folder)) apply_log(folder / "events.log", record);

  const auto other = store.find_request(record.job.request_id());
  if (other && other->job.id() != record.job.id())
    throw std::runtime_error(fmt::format("its request_id \"{}\" belongs to job {}",
                                         record.job.request_id(), other->job.id()));

  store.erase(record.job.id());
  store.insert(record);
  store.update(record, jobs::Durability::full);
  jobs::mark_accepted(folder);
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

  update_unfinished(folder, *store);
  return store;
}

}  // namespace dccast::state
