#pragma once

#include <map>
#include <string>

namespace dccast::client {

/// Runs a command of the user in a shell, as for --notify, and waits for it. One that fails is
/// named on standard error. @param facts  variables that are added to its environment
void run_user_command(const std::string& command, const std::map<std::string, std::string>& facts);

}  // namespace dccast::client
