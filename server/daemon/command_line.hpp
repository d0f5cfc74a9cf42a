#pragma once

#include <string>
#include <vector>

namespace dccast::daemon {

struct CommandLine {
  std::string config_file;             ///< empty: all defaults
  std::vector<std::string> overrides;  ///< "key=value"
  int exit_code = -1;                  ///< 0 or more: leave with it, everything has been said
};

/// Reads the command line; prints help, version or what is wrong with it.
CommandLine read_command_line(int argc, char** argv);

}  // namespace dccast::daemon
