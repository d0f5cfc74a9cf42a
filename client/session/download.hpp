#pragma once

#include <filesystem>
#include <functional>
#include <iosfwd>
#include <string>

#include "client/session/connection.hpp"

namespace dccast::client {

/// A file that was fetched.
struct Download {
  std::int64_t bytes = 0;
  std::int64_t resumed_at = 0;  ///< number of bytes present from an earlier attempt
  std::string sha256;
};

/// Downloads an artifact of a job to `file`. Data are written to `file`.part first; an existing
/// part file is continued. The file gets its name only if its SHA-256 is correct. An interrupted
/// stream is continued a few times. Throws CommandFailed (server not reachable, no such job or
/// artifact, disk error) and Interrupted; the part file then holds the data received so far.
Download download(Connection& connection, const std::string& id, const std::string& artifact,
                  const std::filesystem::path& file, std::ostream& messages);

/// A small file of a job, whole: "case.toml" or "worker.log". Throws CommandFailed, Interrupted.
std::string read_file_of_job(Connection& connection, const std::string& id,
                             const std::string& name);

/// Downloads the table of a study in the same way; from the beginning if the study has changed
/// meanwhile.
Download download_study(Connection& connection, const std::string& id,
                        const std::filesystem::path& file, std::ostream& messages);

}  // namespace dccast::client
