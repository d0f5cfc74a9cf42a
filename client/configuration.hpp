#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

namespace dccast::client {

/// The user's own settings: $DCCAST_CONFIG, else dccast/client.toml in $XDG_CONFIG_HOME or in
/// ~/.config. Empty: there is no place for it.
std::filesystem::path configuration_file();

/// Takes the defaults of options from a TOML file: `server` at its top, and for a command a table
/// of its name whose keys are long options, e.g. `[submit]` with `priority = "low"`. What stands in
/// the environment or on the command line comes before it. A file that is not there says nothing.
/// @param app     with all its commands, not parsed yet
/// @param server  set where the file names one
/// Throws CommandFailed for a file that cannot be read, an unknown key or a wrong value, with its
/// line.
void apply_configuration(const std::filesystem::path& file, CLI::App& app, std::string& server);

}  // namespace dccast::client
