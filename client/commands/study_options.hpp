#pragma once

#include <string>

#include <CLI/CLI.hpp>

#include "client/study_creation.hpp"

namespace dccast::client::commands {

/// Options of every command that creates or continues a study.
struct StudyOptions {
  StudyCase base;
  std::string study;  ///< study to continue
  std::string plot;   ///< path of an HTML page; "-" is standard output
  bool no_wait = false;
  bool force = false;
  bool json = false;
};

/// Help texts that differ between commands.
struct StudyOptionTexts {
  const char* study;
  const char* plot;
  const char* json;
};

/// Adds --set, --label, --study, --no-wait, --plot, --force and --json.
void add_study_options(CLI::App& command, StudyOptions& options, const StudyOptionTexts& texts);

}  // namespace dccast::client::commands
