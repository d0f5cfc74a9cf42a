#pragma once

#include <string>
#include <vector>

#include "client/commands/commands.hpp"

namespace dccast::client {

/// Parses the arguments (without the program's name) and runs the subcommand. Never throws.
/// @return exit code of the process
int run_command_line(const std::vector<std::string>& arguments, commands::Program& program);

}  // namespace dccast::client
