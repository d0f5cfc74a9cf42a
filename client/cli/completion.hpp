#pragma once

#include <string>
#include <vector>

#include "client/cli/options.hpp"

namespace dccast::client {

/// A shell script that completes commands, options, their choices and job ids.
/// @param shell  "bash", "zsh" or "fish"
std::string completion_script(const std::vector<cli::CommandSummary>& commands,
                              const std::string& shell);

}  // namespace dccast::client
