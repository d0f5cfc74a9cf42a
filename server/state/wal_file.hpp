#pragma once

#include <filesystem>

namespace dccast::state {

/// What a write-ahead log of SQLite looks like before SQLite opens it. SQLite takes damage for the
/// end of the file and says nothing, and removes the file when the store is closed. Format:
/// https://www.sqlite.org/fileformat2.html#the_write_ahead_log
enum class WalState {
  empty,           ///< not there, or without a frame
  sound,           ///< every frame of this generation has its checksum
  damaged_header,  ///< SQLite would drop all of it
  damaged_frames,  ///< SQLite would drop a frame and those behind it
};

/// @throws std::system_error  the file cannot be read
WalState inspect_wal(const std::filesystem::path& path);

}  // namespace dccast::state
