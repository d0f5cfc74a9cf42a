#pragma once

#include <chrono>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <optional>
#include <string>

namespace dccast::jobs {

/// Whether an error means that the daemon is short of disk, descriptors or memory: a state that
/// passes, and no fault of a job. @return what is lacking, in words; nothing for any other error
std::optional<std::string> daemon_lacks(const std::exception& error);

/// @throws std::system_error (ENOSPC)  the file system of a directory has less free than that
/// [bytes]
void require_free_space(const std::filesystem::path& directory, std::int64_t minimum);

/// Writes a file of some size into a directory, syncs it to disk and removes it again.
/// @throws std::system_error  the directory takes nothing
void probe_directory(const std::filesystem::path& directory);

/// Why no job is started now, and when to see whether that has passed. A hold is the daemon's own
/// fault, such as a full disk: it fails no job.
class QueueHold {
public:
  using Clock = std::chrono::steady_clock;

  /// Holds the queue; the first reason is kept until the hold is lifted. @return whether it is new
  bool set(const std::string& reason);
  void lift();
  bool holds() const { return reason_.has_value(); }
  /// Empty when nothing holds the queue.
  std::string reason() const { return reason_.value_or(""); }
  /// When to look again.
  Clock::time_point next_look() const { return next_look_; }
  void look_again_later();

private:
  std::optional<std::string> reason_;
  Clock::time_point next_look_{};
  Clock::time_point lifted_{};
  Clock::duration interval_{};
};

}  // namespace dccast::jobs
