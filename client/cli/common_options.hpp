#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "client/cli/options.hpp"
#include "client/session/studies.hpp"

/// Options that several commands have.
namespace dccast::client {

/// The option `--set KEY=VALUE`, which may be given several times.
void add_set_option(const Command& command, std::vector<std::string>& changes,
                    const std::string& help =
                        "Change one key of the case, e.g. --set mesh.rows=30, --set "
                        "schedule.hold=\"5 s\" or --set schedule.water_flow.scale=\"0.8 until 100 "
                        "mm\"; may be given several times");

/// The option `--columns FILE` of commands that read what a plant measures.
void add_columns_option(const Command& command, std::string& file);

/// The flag `--force`, without which no file is overwritten.
void add_force_flag(const Command& command, bool& force);

/// Options of every command that creates or continues a study.
struct StudyOptions {
  /// The case from which a new study is made; its file is empty where --study is given.
  StudyCase base;
  std::string study;  ///< study to continue
  std::string plot;   ///< path of an HTML page; "-" is standard output
  bool no_wait = false;
  /// As --force, --json.
  bool force = false;
  bool json = false;
};

/// Help texts that differ between commands.
struct StudyOptionTexts {
  /// Help texts of --study, --plot and --json, which differ between the kinds of study.
  const char* study;
  const char* plot;
  const char* json;
};

/// Adds --set, --label, --study, --no-wait, --plot, --force and --json.
void add_study_options(const Command& command, StudyOptions& options,
                       const StudyOptionTexts& texts);

/// Follows a study to its end and shows its progress on stderr.
/// @param come_back  command that continues to follow it, for the message of Interrupted
void follow_with_progress(Connection& connection, const std::string& id,
                          const std::string& come_back);

/// The length in an option's value such as "285 mm" [m]. Throws CommandFailed, naming the option.
double metres_of(const std::string& text, const char* option);

/// Throws CommandFailed if the file exists and must not be overwritten; "-" and no name are free.
void require_free(const std::filesystem::path& file, bool force);

/// Writes a whole file; one that could not be written whole is removed. Throws CommandFailed.
void write_file(const std::filesystem::path& file, const std::string& content);

/// Writes a file and reports it on standard error; "-" is standard output. Throws CommandFailed.
void write_output(const std::string& path, const std::string& content);

}  // namespace dccast::client
