#pragma once

#include <filesystem>
#include <ostream>

#include "server/state/state_folder.hpp"

namespace dccast::state {

/// Name of the list of a backup's files with their SHA-256, in the form of sha256sum(1). It is
/// written last: a backup without it is not complete.
inline constexpr const char* manifest_file = "MANIFEST.sha256";

/// Copies a state folder, while its daemon works or not, to a new or empty directory.
///
/// The store comes first, in one instant; then the folders of the jobs that are in it. So every job
/// that was acknowledged before has its row and its folder, and a folder is never older than its
/// row: that is how a daemon finds them after a crash, and `check` lets rows follow the event logs.
/// Within a folder the checkpoint comes before the journal and the event log it counts on, and
/// results come last, as a terminal event is written when they have their final names.
/// @throws std::runtime_error  `to` is not empty, the store is damaged, or a file cannot be copied
void back_up(const StateFolder& folder, const std::filesystem::path& to, std::ostream& out);

/// Makes a state folder from a backup and checks it. @return damages that are left, as check()
/// @throws std::runtime_error  the folder is not empty, or the backup is not complete or damaged
int restore(const StateFolder& folder, const std::filesystem::path& from, std::ostream& out);

}  // namespace dccast::state
