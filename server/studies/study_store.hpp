#pragma once

#include <climits>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "server/jobs/store/sqlite.hpp"
#include "server/studies/study_file.hpp"

namespace dccast::studies {

/// Number of a study's runs by state.
struct RunCounts {
  std::map<v1::JobState, int> by_state;  ///< without runs whose job was deleted
  int waiting = 0;                       ///< queued runs that have a job
  std::int64_t last_end_ms = 0;          ///< last end of a job, since 1970

  /// Runs in a state; all; those that have ended.
  int of(v1::JobState state) const;
  int all() const;
  int ended() const;
};

/// All studies with their runs, in the file of the job store, which is opened first. Safe to use
/// from several threads. Every call throws jobs::StoreError if the file cannot be read or written.
/// A change survives a crash of the machine once its call has returned.
class StudyStore {
public:
  /// Opens or makes the tables. @throws std::exception  the file cannot be opened
  explicit StudyStore(const std::filesystem::path& path);

  /// Adds a study and its runs. @return false if its id or request_id is taken
  bool insert(const StudyRecord& record, const std::vector<RunRecord>& runs);
  /// Replaces the request and adds runs.
  void extend(const StudyRecord& record, const std::vector<RunRecord>& more);
  /// Marks a study whose removal has begun; from then on only removing() returns it.
  void begin_removal(const std::string& id);
  /// Deletes the rows of a study and of its runs.
  void erase(const std::string& id);

  /// A row; empty if there is none.
  std::optional<StudyRecord> find(const std::string& id);
  std::optional<StudyRecord> find_request(const std::string& request_id);
  /// For recovery: all studies, and those whose removal has begun.
  std::vector<std::string> ids();
  std::vector<StudyRecord> removing();

  /// A page of studies, newest first.
  struct Page {
    std::int64_t before_ms =
        INT64_MAX;  ///< only studies created before, or then and with a lesser id
    std::string before_id{};
    int size = 50;
    std::string owner{};                ///< empty: all
    std::string id_prefix{};            ///< empty: all
    std::vector<std::string> labels{};  ///< only studies that have all of them
  };
  /// Newest first.
  std::vector<StudyRecord> list(const Page& page);

  /// Counts and rows of the runs of a study.
  RunCounts counts(const std::string& id);
  std::vector<RunRecord> runs(const std::string& id);
  /// Studies with runs that wait to be queued, oldest first.
  std::vector<std::string> to_feed();
  /// The first run without a job that waits to be queued.
  std::optional<RunRecord> next_to_queue(const std::string& id);

  /// Gives a run its job. @param followed  also adds the next run of a growing plan, to wait
  /// @return false if the run has been cancelled meanwhile
  bool set_job(const std::string& id, const RunRecord& run, bool followed = false);
  /// Removes a run that waits to be queued and is not needed.
  void drop(const std::string& id, int number);
  /// Ends a run whose case is refused, without a job.
  void refuse(const std::string& id, int number, const v1::Finding& failure, std::int64_t now_ms);
  /// Cancels all runs that wait to be queued.
  void cancel_waiting(const std::string& id, std::int64_t now_ms);
  /// Lets these runs wait to be queued again, as further attempts.
  void queue_again(const std::string& id, const std::vector<RunRecord>& runs);

private:
  /// As list(), without regard to labels.
  std::vector<StudyRecord> with_any_label(const Page& page);

  jobs::SharedDatabase database_;
};

}  // namespace dccast::studies
