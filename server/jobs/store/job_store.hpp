#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/store/sqlite.hpp"

namespace dccast::jobs {

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
  void erase(const std::string& id);

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
  template <typename... Values>
  void write(Durability durability, std::string_view sql, const Values&... values);
  /// @param take  called with each row
  template <typename Take, typename... Values>
  void read(std::string_view sql, const Take& take, const Values&... values);
  template <typename... Values>
  std::int64_t number(std::string_view sql, const Values&... values);
  template <typename... Values>
  std::vector<JobRecord> select(const std::string& where_and_order, const Values&... values);

  std::mutex mutex_;  ///< of the connection that writes
  Database database_;
  bool bulk_ = false;
  std::mutex reading_;
  std::optional<Database> reader_;
};

}  // namespace dccast::jobs
