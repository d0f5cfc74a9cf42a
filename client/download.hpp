#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

#include "client/connection.hpp"

namespace dccast::client {

struct Download {
  std::int64_t bytes = 0;
  std::int64_t resumed_at = 0;  ///< bytes that were there from an earlier attempt
  std::string sha256;
};

/// Fetches an artifact of a job into `file`. Bytes go to `file`.part first; one that is there
/// already is continued. The file appears under its name only when its SHA-256 is right. A stream
/// that is cut is continued a few times. Throws CommandFailed: server away, no such job or
/// artifact, disk; Interrupted, the part file complete up to what has come.
Download download(Connection& connection, const std::string& id, const std::string& artifact,
                  const std::filesystem::path& file, std::ostream& talk);

/// Fetches the table of a study in the same way. One that has gone on meanwhile is fetched anew.
Download download_study(Connection& connection, const std::string& id,
                        const std::filesystem::path& file, std::ostream& talk);

}  // namespace dccast::client
