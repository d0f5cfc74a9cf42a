#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/store/sqlite.hpp"

namespace dccast::jobs {

/// All jobs in one SQLite file (WAL), an index of the folders of the jobs: a row is the record of a
/// job at its last change. Writes survive a crash of the daemon; after a crash of the machine rows
/// may be old or missing, and are made again from the folders. Safe to use from several threads;
/// readers never wait for a writer. Every call throws StoreError if the file cannot be read or
/// written. The virtual functions are those that tests let fail.
class JobStore {
public:
  /// Virtual, so that tests can have a store that fails.
  virtual ~JobStore() = default;
  /// Opens or creates the store. @throws StoreError  also for a file of another version
  explicit JobStore(const std::filesystem::path& path);

  /// Adds a job, unless a job with its request_id exists.
  /// @return the existing job; nothing if the new one was added
  std::optional<JobRecord> insert(const JobRecord& record);
  /// Adds a job, or replaces its row.
  virtual void put(const JobRecord& record);
  /// Deletes a row. It survives a crash of the machine: a row without a folder is a lost folder.
  void erase(const std::string& id);

  /// Rows by id and by the id of the request; empty if there is none.
  virtual std::optional<JobRecord> find(const std::string& id);
  std::optional<JobRecord> find_request(const std::string& request_id);
  /// The id of the newest job that has succeeded with this key and this solver.
  std::optional<std::string> find_answer(const std::string& answer_key, const std::string& solver);
  /// Jobs that have not ended, oldest first.
  std::vector<JobRecord> unfinished();
  /// Size of the cases and attachments of all jobs that have not ended [bytes].
  std::int64_t unfinished_bytes();
  /// Number of an owner's jobs that have not ended.
  int unfinished_of(const std::string& owner);
  /// Disk space of all jobs of an owner [bytes].
  std::int64_t bytes_of(const std::string& owner);

  /// The jobs of an owner in one state, with their disk space [bytes].
  struct Group {
    std::string owner;
    v1::JobState state;
    std::int64_t jobs, bytes;
    std::int64_t oldest_ms;  ///< submission of the oldest one
  };
  std::vector<Group> groups();

  /// A job that has ended, for its deletion by age or size.
  struct Ended {
    std::string id;
    std::int64_t ended_ms, bytes;
    bool pinned;
  };
  /// The ended jobs that are no runs of studies, in the order of their ends.
  std::vector<Ended> ended();
  /// Tests whether a write succeeds.
  void probe();
  /// Ids of all jobs, for the comparison with the folders.
  std::set<std::string> ids();
  /// Number of jobs in one state.
  int count(v1::JobState state);

  /// Conditions and place of a page.
  struct Page {
    std::int64_t before_ms = INT64_MAX;  ///< only jobs created earlier, or then with a smaller id
    std::string before_id{};
    std::vector<v1::JobState> states{};  ///< empty: all
    std::string study{};                 ///< empty: all jobs, of a study or not
    std::string owner{};                 ///< empty: all
    std::string id_prefix{};             ///< empty: all
    std::vector<std::string> labels{};   ///< only jobs that have all of them
    std::int64_t since_ms = 0;           ///< only jobs created then or later
    std::string title{};                 ///< shell pattern; empty: all
    static constexpr int all = -1;
    int size = 50;
  };
  /// Newest first.
  std::vector<JobRecord> list(const Page& page);

  /// Checks all pages of the file. @return the first fault; empty for none
  std::string first_fault();
  /// Copies the committed state to a new file, while other threads continue to write here.
  void copy_to(const std::filesystem::path& path);

private:
  /// One statement that changes rows. @return their number
  template <typename... Values>
  int write(std::string_view sql, const Values&... values);
  /// @param on_conflict  SQL behind the row @return number of rows that have changed
  int write_row(const JobRecord& record, const std::string& on_conflict);
  /// @param take  called with each row
  template <typename Take, typename... Values>
  void read(std::string_view sql, const Take& take, const Values&... values);
  /// The number in the first row of a query; 0 without a row.
  template <typename... Values>
  std::int64_t number(std::string_view sql, const Values&... values);
  /// Rows of jobs. @param where_and_order  SQL behind "FROM job"
  template <typename... Values>
  std::vector<JobRecord> select(const std::string& where_and_order, const Values&... values);

  SharedDatabase writer_;
  std::optional<SharedDatabase> reader_;  ///< opened once the tables are there
};

}  // namespace dccast::jobs
