#include "server/state/state_folder.hpp"

#include <fcntl.h>
#include <sys/file.h>

namespace dccast::state {

StateLock::StateLock(const StateFolder& folder) : lock_(folder.lock(), O_RDWR | O_CREAT) {
  if (::flock(lock_.descriptor(), LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error("another dccastd uses the data directory " + folder.path().string() +
                             "; stop it, or set another data_directory");
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
