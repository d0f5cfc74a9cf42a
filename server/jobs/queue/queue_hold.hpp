#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "proto/refusal/refusal.hpp"

namespace dccast::jobs {

/// Whether an error means that the daemon is short of disk, descriptors or memory: a state that
/// passes, and no fault of a job. @return a description of the lack; nothing for any other error
std::optional<std::string> daemon_lacks(const std::exception& error);

/// Less of a disk is free than the setting `limits.minimum_free`.
class FreeSpaceShort : public std::system_error {
public:
  FreeSpaceShort(const std::filesystem::path& directory, std::int64_t free, std::int64_t minimum);
  const refusal::Facts& facts() const { return facts_; }

private:
  refusal::Facts facts_;
};

/// Checks the free space of the file system that holds a directory. @param minimum  [bytes]
/// @throws FreeSpaceShort  less is free
void require_free_space(const std::filesystem::path& directory, std::int64_t minimum);

/// Writes a file of some size into a directory, syncs it to disk and removes it again.
/// @throws std::system_error  the directory is not writable
void probe_directory(const std::filesystem::path& directory);

/// Reason why no job is started now, and when to check whether it has passed. A hold is a fault of
/// the daemon, such as a full disk, so no job fails because of it.
class QueueHold {
public:
  using Clock = std::chrono::steady_clock;

  /// Holds the queue; the first reason is kept until the hold is lifted. @return whether it is new
  bool set(const std::string& reason);
  /// Starts jobs again.
  void lift();
  bool holds() const { return reason_.has_value(); }
  /// Empty if nothing holds the queue.
  std::string reason() const { return reason_.value_or(""); }
  /// Time of the next check.
  Clock::time_point next_check() const { return next_check_; }
  /// Sets the time of the next check.
  void retry_later();

private:
  /// Why no job starts; empty while they do.
  std::optional<std::string> reason_;
  Clock::time_point next_check_{};
  Clock::time_point lifted_{};
  Clock::duration interval_{};
};

}  // namespace dccast::jobs
