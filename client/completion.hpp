#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace dccast::client {

/// A shell script that completes commands, options, their choices and job ids.
/// @param app    the application with all its commands
/// @param shell  "bash", "zsh" or "fish"
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace dccast::client
