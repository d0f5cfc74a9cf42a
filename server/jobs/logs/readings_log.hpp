#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/storage/record_log.hpp"
#include "dccast/v1/follow.pb.h"
#include "server/access/limits.hpp"

namespace dccast::jobs {

/// The record of a job that follows a casting, in its folder. Only such a job has it.
///
/// Format: 8 bytes "DCCASTRD", version 1 and zero as in EVENT_LOG.md, then a frame for each
/// RecordEntry: how the casting is followed, and the readings in the order of their numbers, each
/// with the time of its arrival. The daemon appends, the worker reads.
inline constexpr const char* readings_file = "readings.log";

/// Longest RecordEntry, for writer and reader alike [bytes].
inline constexpr std::size_t longest_entry = 64 * 1024;
/// Readings of a job [1], and the size of its record [bytes]. A forecast reads all of it.
inline constexpr std::int64_t most_readings = 100'000;
inline constexpr std::int64_t longest_record = 32'000'000;
/// Least time from one reading to the next [s].
inline constexpr double least_spacing_s = 0.01;
/// Readings that a job takes [1/s], and at once after a pause [1]: those of eight hours.
inline constexpr double readings_per_s = 1000.0, readings_at_once = 30'000.0;

/// Whether a record can begin with this. The room that is left is for what the entry has around it.
inline bool fits_record(const v1::Following& following) {
  return following.ByteSizeLong() + 64 <= longest_entry;
}

/// Creates a record without readings, synced to disk. @param following  fits_record()
/// @throws std::system_error
void create_readings_log(const std::filesystem::path& job_folder, const v1::Following& following);

/// Whether a job follows readings.
bool follows_readings(const std::filesystem::path& job_folder);

/// The record is damaged: a reading that was acknowledged cannot be read.
class DamagedReadings : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Reads a record from its beginning, while another process may append to it.
class ReadingsReader {
public:
  /// @throws std::system_error, DamagedReadings
  explicit ReadingsReader(const std::filesystem::path& job_folder);

  /// The readings that were added since the last call.
  /// @throws std::system_error
  /// @throws DamagedReadings  also if whole readings follow one that cannot be read: these were
  ///                          acknowledged
  std::vector<v1::Reading> read_new();

  const v1::Following& following() const { return following_; }
  /// When the last reading that was read arrived at the server; empty: not known, or none yet.
  const std::optional<google::protobuf::Timestamp>& last_arrival() const { return last_arrival_; }
  std::int64_t end() const { return end_; }  ///< byte after the last reading that was read

private:
  /// The next whole entry, if there is one.
  std::optional<v1::RecordEntry> next(storage::FileWindow& window);
  /// Looks for a whole entry behind bytes that are none. @throws DamagedReadings  there is one
  void require_no_gap(storage::FileWindow& window);

  storage::File file_;
  v1::Following following_;
  std::optional<google::protobuf::Timestamp> last_arrival_;
  std::int64_t end_;
  std::int64_t number_ = 0;         ///< of the last reading
  std::int64_t size_searched_ = 0;  ///< of the file when it was last searched for a gap [bytes]
};

/// A call breaks the rule that numbers have no holes.
class MissingReading : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// A reading is not later than the one before it by `least_spacing_s`, follows the one that closes
/// the record, or is longer than an entry may be.
class UnfitReading : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The record is as long as it may become.
class RecordFull : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Readings come faster than a job takes them.
class TooManyAtOnce : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// The record of a job, as the daemon adds to it. Safe to use from several threads.
class ReadingsLog {
public:
  /// Moves what follows the last whole reading to a file of its own: a crash leaves there what was
  /// not acknowledged.
  /// @throws std::system_error, DamagedReadings
  explicit ReadingsLog(const std::filesystem::path& job_folder);

  /// How far the record goes.
  v1::AppendReadingsResponse state() const;
  const v1::Following& following() const { return following_; }

  /// Adds what is new among readings, all or nothing, and syncs it to disk.
  /// @throws MissingReading, UnfitReading, RecordFull, TooManyAtOnce, std::system_error  nothing
  /// was
  ///         added
  void append(const google::protobuf::RepeatedPtrField<v1::Reading>& readings);

private:
  /// The state after a reading. @throws MissingReading, UnfitReading, RecordFull
  static void advance(v1::AppendReadingsResponse& state, const v1::Reading& reading);

  mutable std::mutex mutex_;
  storage::RecordLog log_;
  v1::Following following_;
  v1::AppendReadingsResponse state_;  ///< of what is on the disk
  access::Allowance allowance_{readings_per_s, readings_at_once};
};

/// The open records; each file is opened once. Safe to use from several threads.
class ReadingsLogs {
public:
  /// @param jobs_directory  holds one folder per job
  explicit ReadingsLogs(std::filesystem::path jobs_directory)
      : jobs_directory_(std::move(jobs_directory)) {}

  /// The record of a job that follows readings, opened if it is not open yet.
  /// @throws as ReadingsLog's constructor
  std::shared_ptr<ReadingsLog> open(const std::string& job_id);
  /// Closes the file of a job that has ended.
  void close(const std::string& job_id);

private:
  std::filesystem::path jobs_directory_;
  std::mutex mutex_;
  std::map<std::string, std::shared_ptr<ReadingsLog>> logs_;
};

}  // namespace dccast::jobs
