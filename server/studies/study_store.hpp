#pragma once

#include <climits>
#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/store/sqlite.hpp"
#include "server/studies/study_file.hpp"

namespace dccast::studies {

/// Runs of a study by state.
struct RunCounts {
  std::map<v1::JobState, int> by_state;  ///< without runs whose job was deleted
  int waiting = 0;                       ///< of the queued ones those that have a job
  std::int64_t last_end_ms = 0;          ///< latest end of a job, since 1970

  int of(v1::JobState state) const;
  int all() const;
  int ended() const;
};

/// All studies with their runs, in the file of the job store, whose tables JobStore makes: open
/// that first. Safe to use from several threads. Every call throws jobs::StoreError when the file
/// cannot be read or written. What has returned survives a crash of the machine.
class StudyStore {
public:
  explicit StudyStore(const std::filesystem::path& path);

  /// Adds a study and its runs. @return whether it was added: its id and request_id are new
  bool insert(const StudyRecord& record, const std::vector<RunRecord>& runs);
  /// Replaces the request and adds runs.
  void extend(const StudyRecord& record, const std::vector<RunRecord>& more);
  /// Marks a study whose removal has begun; only removing() returns it from then on.
  void begin_removal(const std::string& id);
  void erase(const std::string& id);

  std::optional<StudyRecord> find(const std::string& id);
  std::optional<StudyRecord> find_request(const std::string& request_id);
  std::vector<std::string> ids();
  std::vector<StudyRecord> removing();

  struct Page {
    std::int64_t before_ms =
        INT64_MAX;  ///< only studies created before, or then and with a lesser id
    std::string before_id{};
    int size = 50;
    std::string owner{};  ///< empty: all
  };
  /// Newest first.
  std::vector<StudyRecord> list(const Page& page);

  RunCounts counts(const std::string& id);
  std::vector<RunRecord> runs(const std::string& id);
  /// Studies with runs that wait to be queued, oldest first.
  std::vector<std::string> to_feed();
  std::optional<RunRecord> next_to_queue(const std::string& id);

  /// A run has its job. @param followed  the next run waits from now on, if it is not there yet
  /// @return false when the run was cancelled meanwhile
  bool set_job(const std::string& id, const RunRecord& run, bool followed = false);
  /// A run that waits to be queued is not needed.
  void drop(const std::string& id, int number);
  /// A run whose case is refused ends without a job.
  void refuse(const std::string& id, int number, const v1::Failure& failure, std::int64_t now_ms);
  /// Runs that wait to be queued never will be.
  void cancel_waiting(const std::string& id, std::int64_t now_ms);
  /// These runs wait to be queued again, as further attempts.
  void queue_again(const std::string& id, const std::vector<RunRecord>& runs);

private:
  std::mutex mutex_;
  jobs::Database database_;
};

}  // namespace dccast::studies
