#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/sqlite.hpp"

namespace dccast::jobs {

/// A job with what the service keeps to itself.
struct JobRecord {
  v1::Job job;
  RequestedAction requested_action = RequestedAction::none;  ///< of its folder, not of its row
  std::string request_reason;                                ///< the same
  int losses = 0;                                            ///< times its worker died
  std::int64_t lost_step = -1;  ///< last step reported before the last loss; -1: never lost
  std::string first_loss;       ///< how the worker died the first time: the cause that is kept
  std::int64_t bytes = 0;       ///< of the case and its attachments; once ended of its folder
  std::string answer_key{};     ///< of all that decides its figures, see service/answer_key.hpp
  std::string solver{};         ///< identity of the solver that succeeded with it; empty: none has
};

/// normal: survives a crash of the daemon. full: survives one of the machine.
enum class Durability { normal, full };

/// All jobs, in one SQLite file (WAL): an index of the folders of the jobs. Safe to use from
/// several threads; who reads waits for no write. Every call throws
/// StoreError when the file cannot be read or written; the virtual ones are those that tests let
/// fail.
class JobStore {
public:
  virtual ~JobStore() = default;
  /// Opens the store, or makes it. @throws StoreError  also for a file of another version
  explicit JobStore(const std::filesystem::path& path);

  /// Adds a job, durably. Nothing is added when its request_id is there already.
  /// @return the job that has this request_id already; nothing when the new one was added
  std::optional<JobRecord> insert(const JobRecord& record);
  /// Writes what changes in a job's life.
  virtual void update(const JobRecord& record, Durability durability);
  /// Writes labels and whether the job is kept for good, durably.
  virtual void update_marks(const v1::Job& job);
  void update_bytes(const std::string& id, std::int64_t bytes);
  /// @return whether it was there
  bool erase(const std::string& id);

  virtual std::optional<JobRecord> find(const std::string& id);
  std::optional<JobRecord> find_request(const std::string& request_id);
  /// The newest job that has succeeded with this key by this solver. @return its id
  std::optional<std::string> find_answer(const std::string& answer_key, const std::string& solver);
  /// Jobs that have not ended, oldest first.
  std::vector<JobRecord> unfinished();
  /// What the jobs that have not ended hold of cases and attachments [bytes].
  std::int64_t unfinished_bytes();
  /// Jobs of an owner that have not ended.
  int unfinished_of(const std::string& owner);
  /// What all jobs of an owner hold on the disk [bytes].
  std::int64_t bytes_of(const std::string& owner);

  /// The jobs of an owner in one state.
  struct Group {
    std::string owner;
    v1::JobState state;
    std::int64_t jobs, bytes;
    std::int64_t oldest_ms;  ///< submission of the oldest one
  };
  std::vector<Group> groups();

  /// A job that has ended.
  struct Ended {
    std::string id;
    std::int64_t ended_ms, bytes;
    bool pinned;
  };
  /// The one that ended first comes first. @param of_studies  also those
  std::vector<Ended> ended(bool of_studies);
  /// Writes something durably, for no other reason than to see whether that works.
  void probe();
  std::set<std::string> ids();
  /// Jobs in one state.
  int count(v1::JobState state);

  struct Page {
    std::int64_t before_ms = INT64_MAX;  ///< only jobs created before, or then and with a lesser id
    std::string before_id{};
    std::vector<v1::JobState> states{};  ///< empty: all
    std::string study{};                 ///< empty: all jobs, of a study or not
    std::string owner{};                 ///< empty: all
    std::string id_prefix{};             ///< empty: all
    std::vector<std::string> labels{};   ///< a job has all of them
    std::int64_t since_ms = 0;           ///< only jobs created then or later
    std::string title{};                 ///< pattern of a shell; empty: all
    int size = 50;
  };
  /// Newest first.
  std::vector<JobRecord> list(const Page& page);

  /// While it lives, nothing waits for the disk; its end does, for all. For a store that can be
  /// made again.
  class Bulk {
  public:
    explicit Bulk(JobStore& store) : store_(store) { store_.bulk_ = true; }
    Bulk(const Bulk&) = delete;
    ~Bulk();

  private:
    JobStore& store_;
  };

  /// Reads every page and holds it against the others. @return the first fault; empty for none
  std::string first_fault();
  /// Writes all that is committed to a new file, in one instant, while others go on writing here.
  void copy_to(const std::filesystem::path& path);

private:
  void set_durability(Durability durability);
  std::vector<JobRecord> select(std::string_view where_and_order, const std::string& argument);

  std::mutex mutex_;  ///< of the connection that writes
  Database database_;
  bool bulk_ = false;
  std::mutex reading_;
  std::optional<Database> reader_;
};

/// A case that was found good, ready to become a job.
struct NewJob {
  std::string request_id;  ///< empty: none
  std::string study{};     ///< empty: none
  std::string title;
  v1::Priority priority = v1::NORMAL;
  std::string owner{};         ///< who submits it
  std::string case_sha256;     ///< of the case as it was submitted, with its attachments
  std::string submitted_case;  ///< serialised
  std::string complete_case;   ///< serialised, with defaults and alloy card
  std::vector<std::string> labels{};
  std::vector<v1::CaseChange> changes{};  ///< made in the case already
  std::string case_file{};                ///< as the submitter wrote it; empty: not known
  std::vector<std::string> after{};       ///< jobs that must succeed first
  double time_limit_s = 0.0;              ///< of wall time; 0: none of its own
  std::string mail{};                     ///< for the hook of the server; empty: none
  double estimated_s = 0.0;               ///< what the check took the run for; 0: not known
  std::string answer_key{};               ///< see JobRecord
  /// It starts at once, beside the others, as long as this daemon serves; else as they do.
  bool goes_first = false;
};

/// The job as it is stored first: with an id of its own, queued, created now.
JobRecord record_of_new(const NewJob& new_job, const Attachments& attachments);

}  // namespace dccast::jobs
