#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace dccast::client {

/// The command line as a user sees it: exit code, standard output, standard error.
struct Result {
  int code;
  std::string out, err;
};

/// Runs `dccast` with these arguments against the daemon at `server`.
/// @param configuration  the user's settings; empty: none
Result dccast(std::vector<std::string> arguments, const std::string& server,
              const std::filesystem::path& configuration = {});

}  // namespace dccast::client
