#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace dccast::client {

/// A script that completes commands, options, their choices and ids of jobs in a shell.
/// @param app    with all its commands
/// @param shell  "bash", "zsh" or "fish"
std::string completion_script(const CLI::App& app, const std::string& shell);

}  // namespace dccast::client
