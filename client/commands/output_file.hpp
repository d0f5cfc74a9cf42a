#pragma once

#include <filesystem>
#include <string>

#include <CLI/CLI.hpp>

namespace dccast::client::commands {

/// The flag `--force`, without which no file is overwritten.
void add_force_flag(CLI::App& command, bool& force);

/// Throws CommandFailed if the file exists and must not be overwritten.
void require_free(const std::filesystem::path& file, bool force);

/// Writes a file and reports it; "-" is standard output. Throws CommandFailed.
void write_output(const std::string& path, const std::string& content);

}  // namespace dccast::client::commands
