#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"
#include "server/access/audit.hpp"

namespace dccast::daemon {

/// What becomes of running workers when their daemon goes.
struct WorkerPolicy {
  double patience_s = 300.0;  ///< [s] a worker runs on without a daemon; 0: it ends with its own
  bool left_running = false;  ///< by an orderly stop too, which else stops them at a checkpoint
};

/// What `dccastd user`, `pki` and `audit` are asked for.
struct AdministrationCommand {
  std::string verb;   ///< "user add", "pki show", "audit"
  std::string name;   ///< of a user
  std::string token;  ///< of user line: its name; of user revoke: its id
  std::string role = "submitter";
  std::string directory;  ///< of pki issue
  std::vector<std::string>
      names;     ///< of pki init and renew; empty: the present ones, or this machine's
  int days = 0;  ///< 0: as usual
  access::AuditFilter filter;  ///< of audit
};

enum class Command { serve, check, check_config, backup, restore, administrate };

struct CommandLine {
  Command command = Command::serve;
  bool repair = false;                 ///< of check
  bool deep = false;                   ///< of check
  std::vector<std::string> adopt;      ///< of check: ids
  std::string directory;               ///< of backup and restore
  std::string earlier;                 ///< of backup: one before it; may be empty
  std::string config_file;             ///< empty: all defaults; see usual_settings()
  std::vector<std::string> overrides;  ///< "key=value"
  WorkerPolicy workers;                ///< of serve
  AdministrationCommand administration;
  int exit_code = -1;  ///< 0 or more: leave with it, everything is printed
};

/// Settings that a program takes where none are named: those of the package, if it is from there;
/// else empty. @param program  its path
std::string usual_settings(const std::filesystem::path& program);

/// Reads the command line; prints help, version or what is wrong with it.
CommandLine read_command_line(int argc, char** argv);

/// The settings are not usable; the text names every fault, one a line.
class InvalidConfig : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Reads the settings: file, then overrides, then defaults, all by the schema of config.proto.
/// @param file       TOML; empty: none
/// @param overrides  "key=value" @throws InvalidConfig
v1::DaemonConfig read_config(const std::string& file, const std::vector<std::string>& overrides);

}  // namespace dccast::daemon
