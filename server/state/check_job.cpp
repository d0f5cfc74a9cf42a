// The part of `dccastd check` about one job: its folder, its event log, its results.
#include <fmt/core.h>

#include <array>
#include <system_error>

#include "core/storage/file.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/jobs/logs/stored_job.hpp"
#include "server/state/check.hpp"
#include "server/state/index.hpp"

namespace dccast::state {

namespace {

namespace fs = std::filesystem;

/// Files that only a worker needs, to continue a run.
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
        subject_(fmt::format("job {}: ", record_.job.id())) {}

  void run() {
    if (!has_folder() || !check_row()) return;
    check_log();
    check_readings();
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
      report_.repaired(subject_ + "an interrupted deletion is undone; delete the job again");
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
    try {
      jobs::described_job(folder_);
    } catch (const std::runtime_error& error) {
      report_.damage(fmt::format("{}{}; restore its folder from a backup", subject_, error.what()));
      return false;
    }

    // A row that is ahead of a damaged log has the state that the log has lost: check_log().
    const std::int64_t sequence = jobs::last_state_sequence(folder_);
    if (sequence == 0 || sequence < record_.sequence) return true;
    if (jobs::agrees(record_, jobs::read_job(folder_))) return true;

    const std::string fault =
        subject_ + (record_.sequence < sequence ? "its row is older than its folder"
                                                : "its row is not that of its folder");

    if (options_.repair)
      rebuild_row(fault);
    else
      report_.damage(fault + "; --repair makes the row again");
    return true;
  }

  void rebuild_row(const std::string& fault) {
    index_job(store_, folder_);
    record_ = store_.find(record_.job.id()).value();
    report_.repaired(fault + "; the row is made again");
  }

  /// A job that lacks one of its files would be another job.
  void check_files(const jobs::JobDescription& description) {
    try {
      if (jobs::is_terminal(record_.job.state()))
        jobs::require_files(folder_, description);
      else
        jobs::require_files_to_run(folder_, description);
    } catch (const std::runtime_error& error) {
      report_.damage(fmt::format("{}{}; restore its folder from a backup, or submit the case again",
                                 subject_, error.what()));
    }
  }

  /// The worker does not verify attachments, so a flipped bit in one would falsify the results.
  void check_attachments() {
    const jobs::JobDescription description = jobs::read_job_description(folder_);
    check_files(description);
    if (!options_.deep) return;

    for (const auto& [name, sha256] : description.attachment_sha256) {
      const fs::path path = folder_ / jobs::attachments_folder / name;
      if (storage::kind_of_entry(path) != storage::regular_file ||
          values::sha256_of_file(path) == sha256)
        continue;
      report_.damage(fmt::format(
          "{}its attachment {} is damaged; restore it from a backup, or submit the case "
          "again",
          subject_, name));
    }
  }

  void check_log() {
    const fs::path path = folder_ / "events.log";
    jobs::EventLogContent log;
    if (storage::kind_of_entry(path) == storage::regular_file) log = jobs::scan_event_log(path);
    if (log.last_sequence == 0) return begin_log_again(path);

    for (const jobs::EventGap& gap : log.gaps) report_.note(subject_ + gap.description());
    if (!log.sound_header) repair_log(subject_ + "the header of its events.log is damaged", path);
    if (log.size > log.end)
      repair_log(fmt::format("{}its events.log ends in {} {}", subject_, log.size - log.end,
                             log.torn ? "bytes of a torn event" : "damaged bytes"),
                 path);
    check_end(log, path);
  }

  /// The record of a casting that the job follows.
  void check_readings() {
    if (!jobs::follows_readings(folder_)) return;  // check_files() looks whether it must
    try {
      jobs::ReadingsReader record(folder_);
      record.read_new();
      const auto size = static_cast<std::int64_t>(fs::file_size(folder_ / jobs::readings_file));
      if (size > record.end()) repair_readings(size - record.end());
    } catch (const jobs::DamagedReadings& damage) {
      report_.damage(
          fmt::format("{}{}; restore its folder from a backup, or follow the source again",
                      subject_, damage.what()));
    }
  }

  /// Sets aside what follows the last whole reading, as the daemon does when it appends to it.
  void repair_readings(std::int64_t bytes) {
    const std::string fault = fmt::format("{}its {} ends in {} bytes that are no reading", subject_,
                                          jobs::readings_file, bytes);
    if (!options_.repair) return report_.note(fault + "; they are moved aside when it goes on");
    const jobs::ReadingsLog taken_over(folder_);
    report_.repaired(fault);
  }

  /// Repairs header and end of a log, as the daemon does when it appends to it.
  void repair_log(const std::string& fault, const fs::path& log) {
    if (!options_.repair) return report_.note(fault + "; the next start puts it right");
    jobs::EventLog(log).take_over();
    report_.repaired(fault);
  }

  /// Starts a new log with the state in the row, after setting an existing file aside.
  void begin_log_again(const fs::path& path) {
    const std::string fault = subject_ + "its events.log is lost";
    if (!options_.repair) return report_.damage(fault + "; --repair begins it again");

    if (!storage::kind_of_entry(path).empty())
      fs::rename(path, jobs::free_name(path.string() + ".damaged"));

    jobs::EventLog log(path);
    v1::JobEvent message = jobs::message_event("all earlier events of this job are lost",
                                               v1::JobEvent::Message::WARNING);
    log.append(message);
    append_state(log);
    storage::sync_directory(folder_);
    report_.repaired(fault + "; begun again with the state the store has");
  }

  /// The row keeps what the log tells from now on: a row that is made again would have no more.
  void append_state(jobs::EventLog& log) {
    v1::JobEvent state = jobs::state_event(record_, "as in the store; its events are lost");
    log.append(state);
    log.sync();
    record_ = jobs::read_job(folder_);
    store_.put(record_);
  }

  void check_end(const jobs::EventLogContent& log, const fs::path& path) {
    const v1::JobState in_store = record_.job.state();
    if (!log.last_state || log.last_state->state() == in_store) return;

    const std::string fault =
        fmt::format("{}the store has {}, its events.log ends with {}", subject_,
                    v1::JobState_Name(in_store), v1::JobState_Name(log.last_state->state()));
    if (!jobs::is_terminal(in_store) || log.terminal) {
      if (!options_.repair) return report_.damage(fault + "; --repair takes the log's");
      return rebuild_row(fault);
    }

    // An end that the store has was on the disk in the log, whose last event is lost since.
    if (!options_.repair) return report_.damage(fault + "; --repair adds the last event again");
    jobs::EventLog writer(path);
    append_state(writer);
    report_.repaired(fault + "; the last event is added again");
  }

  void check_artifact(const v1::Artifact& artifact) {
    const fs::path path = folder_ / artifact.name();
    std::error_code error;
    const auto size = static_cast<std::int64_t>(fs::file_size(path, error));

    std::string fault;
    if (error)
      fault = "is missing";
    else if (size != artifact.size_bytes())
      fault = fmt::format("has {} bytes, not {}", size, artifact.size_bytes());
    else if (options_.deep && values::sha256_of_file(path) != artifact.sha256())
      fault = "is damaged: its SHA-256 differs";
    if (fault.empty()) return;

    report_.damage(fmt::format("{}{} {}; restore it from a backup, or run the case again", subject_,
                               artifact.name(), fault));
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
