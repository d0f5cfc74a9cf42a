// What `dccastd check` looks at in one job: its folder, its event log, its results.
#include <array>
#include <system_error>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/state/check.hpp"
#include "server/state/index.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// What a worker needs to go on, and no one once the job has ended well.
constexpr std::array leftover_names{"checkpoint.bin", "journal.bin"};

class JobCheck {
public:
  JobCheck(const StateFolder& state, jobs::JobStore& store, const CheckOptions& options,
           Report& report, jobs::JobRecord record)
      : state_(state),
        store_(store),
        options_(options),
        report_(report),
        record_(std::move(record)),
        folder_(state.jobs() / record_.job.id()),
        subject_("job " + record_.job.id() + ": ") {}

  void run() {
    if (!has_folder() || !check_row()) return;
    if (options_.index_only) return check_running();
    check_log();
    check_attachments();
    for (const v1::Artifact& artifact : record_.job.artifacts()) check_artifact(artifact);
    if (record_.job.state() == v1::SUCCEEDED || record_.job.state() == v1::CANCELLED)
      check_leftovers();
  }

private:
  bool has_folder() {
    if (fs::exists(folder_)) return true;
    const fs::path removed = folder_.string() + ".removed";
    if (options_.repair && fs::exists(removed)) {
      jobs::undo_removal(removed);
      report_.repaired(subject_ + "a deletion that was cut short is undone; delete it again");
    } else if (options_.repair && jobs::release_folder(state_.jobs(), record_.job.id())) {
      report_.repaired(subject_ + "its folder is back out of quarantine");
    } else {
      report_.damage(subject_ +
                     "its folder is missing; restore it from a backup, or delete the job");
    }
    return fs::exists(folder_);
  }

  /// @return whether the folder describes the job
  bool check_row() {
    std::string what;
    try {
      if (agrees(record_, described_job(folder_))) return true;
      what = subject_ + "its row is not that of its folder";
    } catch (const std::runtime_error& error) {
      report_.damage(subject_ + error.what() + "; restore its folder from a backup");
      return false;
    }
    if (options_.repair)
      make_row_again(what);
    else
      report_.damage(what + "; --repair makes the row again");
    return true;
  }

  void make_row_again(const std::string& what) {
    index_job(store_, folder_);
    record_ = store_.find(record_.job.id()).value();
    report_.repaired(what + "; the row is made again");
  }

  /// A row that has ended although the run in the folder has not.
  void check_running() {
    if (jobs::is_terminal(record_.job.state()) && jobs::signs_in(folder_).claimed_ns != 0 &&
        !jobs::scan_event_log(folder_ / "events.log").terminal)
      make_row_again(subject_ + "the store has it as ended");
  }

  /// Attachments are read by the worker alone; a bit that flips in one would go into the results.
  void check_attachments() {
    for (const auto& [name, sha256] : jobs::read_job_description(folder_).attachment_sha256) {
      const fs::path path = folder_ / jobs::attachments_folder / name;
      if (fs::exists(path) && (!options_.deep || values::sha256_of_file(path) == sha256)) continue;
      report_.damage(subject_ + "its attachment " + name + " is missing or damaged" +
                     "; restore it from a backup, or submit the case again");
    }
  }

  void check_log() {
    const fs::path path = folder_ / "events.log";
    jobs::EventLogContent log;
    if (storage::kind_of_entry(path) == storage::regular_file) log = jobs::scan_event_log(path);
    if (log.last_sequence == 0) return begin_log_again(path);
    for (const jobs::EventGap& gap : log.gaps) report_.note(subject_ + gap.description());
    if (!log.sound_header) put_right(subject_ + "the header of its events.log is damaged", path);
    if (log.size > log.end)
      put_right(subject_ + "its events.log ends in " + std::to_string(log.size - log.end) +
                    (log.torn ? " bytes of a torn event" : " damaged bytes"),
                path);
    check_end(log, path);
  }

  /// Opening a log for writing repairs its ends, which the daemon does too.
  void put_right(const std::string& what, const fs::path& log) {
    if (!options_.repair) return report_.note(what + "; the next start puts it right");
    jobs::EventLog(log).take_over();
    report_.repaired(what);
  }

  /// Any file there is moves aside; the row has how the job stands.
  void begin_log_again(const fs::path& path) {
    const std::string what = subject_ + "its events.log is lost";
    if (!options_.repair) return report_.damage(what + "; --repair begins it again");
    if (!storage::kind_of_entry(path).empty())
      fs::rename(path, jobs::free_name(path.string() + ".damaged"));
    jobs::EventLog log(path);
    v1::JobEvent message = jobs::message_event("all earlier events of this job are lost",
                                               v1::JobEvent::Message::WARNING);
    log.append(message);
    append_state(log);
    storage::sync_directory(folder_);
    report_.repaired(what + "; begun again with the state the store has");
  }

  void append_state(jobs::EventLog& log) {
    v1::JobEvent state = jobs::state_event(record_.job, "as in the store; its events are lost");
    log.append(state);
    log.sync();
  }

  void check_end(const jobs::EventLogContent& log, const fs::path& path) {
    const v1::JobState in_store = record_.job.state();
    if (!log.last_state || log.last_state->state() == in_store) return;
    const std::string what = subject_ + "the store has " + v1::JobState_Name(in_store) +
                             ", its events.log ends with " +
                             v1::JobState_Name(log.last_state->state());
    if (!jobs::is_terminal(in_store) || log.terminal) {
      if (!options_.repair) return report_.damage(what + "; --repair takes the log's");
      return make_row_again(what);
    }
    if (!options_.repair) return report_.damage(what + "; --repair adds the last event again");
    jobs::EventLog writer(path);
    append_state(writer);
    report_.repaired(what + "; the last event is added again");
  }

  void check_artifact(const v1::Artifact& artifact) {
    const fs::path path = folder_ / artifact.name();
    std::error_code error;
    const auto size = static_cast<std::int64_t>(fs::file_size(path, error));
    std::string what;
    if (error)
      what = " is missing";
    else if (size != artifact.size_bytes())
      what =
          " has " + std::to_string(size) + " bytes, not " + std::to_string(artifact.size_bytes());
    else if (options_.deep && values::sha256_of_file(path) != artifact.sha256())
      what = " is damaged: its SHA-256 differs";
    if (!what.empty())
      report_.damage(subject_ + artifact.name() + what +
                     "; restore it from a backup, or run the case again");
  }

  void check_leftovers() {
    std::uintmax_t bytes = 0;
    for (const char* name : leftover_names)
      if (fs::exists(folder_ / name)) bytes += fs::file_size(folder_ / name);
    if (bytes == 0) return;
    if (options_.repair) jobs::remove_run_files(folder_);
    ++report_.with_leftovers;
    report_.leftover_bytes += bytes;
  }

  const StateFolder& state_;
  jobs::JobStore& store_;
  const CheckOptions& options_;
  Report& report_;
  jobs::JobRecord record_;
  const fs::path folder_;
  const std::string subject_;
};

}  // namespace

void check_job(const StateFolder& folder, jobs::JobStore& store, const std::string& id,
               const CheckOptions& options, Report& report) {
  if (auto record = store.find(id))
    JobCheck(folder, store, options, report, std::move(*record)).run();
}

}  // namespace dccast::state
