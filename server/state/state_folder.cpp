#include "server/state/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>

#include <chrono>
#include <thread>

namespace dccast::state {

namespace {

/// A daemon that was killed in the instant in which it started a process leaves its lock to that
/// one, which lets go of it as soon as it gets the processor: seconds on a busy machine.
constexpr std::chrono::seconds longest_wait{3};
constexpr std::chrono::milliseconds between_tries{20};

}  // namespace

StateLock::StateLock(const StateFolder& folder) : lock_(folder.lock(), O_RDWR | O_CREAT) {
  const auto end = std::chrono::steady_clock::now() + longest_wait;
  while (::flock(lock_.descriptor(), LOCK_EX | LOCK_NB) != 0) {
    if (std::chrono::steady_clock::now() > end)
      throw std::runtime_error("another dccastd uses the data directory " + folder.path().string() +
                               "; stop it, or set another data_directory");
    std::this_thread::sleep_for(between_tries);
  }
}

void make_state_folder(const StateFolder& folder) {
  std::filesystem::create_directories(folder.path());
  std::filesystem::permissions(folder.path(), std::filesystem::perms::owner_all);
}

std::string repair_remedy(const StateFolder& folder) {
  return "nothing was changed: restore a backup, or rebuild the store from the job folders with "
         "dccastd check --repair --set data_directory=" +
         folder.path().string();
}

}  // namespace dccast::state
