#pragma once

#include <filesystem>

#include <CLI/CLI.hpp>

namespace dccast::client::commands {

/// The flag `--force`, without which no file is overwritten.
void add_force_flag(CLI::App& command, bool& force);

/// Throws CommandFailed if the file is there and must not be overwritten.
void require_free(const std::filesystem::path& file, bool force);

}  // namespace dccast::client::commands
