#pragma once

#include <string>
#include <vector>

#include "server/daemon/administration.hpp"
#include "server/daemon/worker_policy.hpp"

namespace dccast::daemon {

enum class Command { serve, check, backup, restore, administrate };

struct CommandLine {
  Command command = Command::serve;
  bool repair = false;                 ///< of check
  bool deep = false;                   ///< of check
  std::vector<std::string> adopt;      ///< of check: ids
  std::string directory;               ///< of backup and restore
  std::string config_file;             ///< empty: all defaults
  std::vector<std::string> overrides;  ///< "key=value"
  WorkerPolicy workers;                ///< of serve
  AdministrationCommand administration;
  int exit_code = -1;  ///< 0 or more: leave with it, everything is printed
};

/// Reads the command line; prints help, version or what is wrong with it.
CommandLine read_command_line(int argc, char** argv);

}  // namespace dccast::daemon
