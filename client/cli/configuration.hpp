#pragma once

#include <filesystem>
#include <string>

#include "client/cli/options.hpp"

namespace dccast::client {

/// Path of the user's settings: $DCCAST_CONFIG, else dccast/client.toml in $XDG_CONFIG_HOME or
/// ~/.config. Empty if none of these is defined.
std::filesystem::path configuration_file();

/// Sets the defaults of options from a TOML file: `server` at the top level, and for each command a
/// table with its name whose keys are long options, e.g. `[submit]` with `priority = "low"`. The
/// environment and the command line take precedence. A missing file is no error.
/// @param line    with all its commands, before parsing
/// @param server  set if the file names one
/// Throws CommandFailed for a file that cannot be read, an unknown key or a wrong value, with its
/// line.
void apply_configuration(const std::filesystem::path& file, cli::CommandLine& line,
                         std::string& server);

}  // namespace dccast::client
