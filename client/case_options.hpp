#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// The option `--set KEY=VALUE`, which may be given several times.
/// @param changes  must outlive the parsing of the command line
CLI::Option* add_set_option(CLI::App& command, std::vector<std::string>& changes);

/// The changes given by the user, in order.
std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts);

/// The length in an option's value such as "285 mm" [m]. Throws CommandFailed, naming the option.
double metres_of(const std::string& text, const char* option);

/// "schedule.hold = 5 s, mesh.rows = 30"; empty for none.
template <class Changes>
std::string changes_text(const Changes& changes) {
  std::string text;
  for (const v1::CaseChange& change : changes)
    text += (text.empty() ? "" : ", ") + change.key() + " = " + change.value();
  return text;
}

}  // namespace dccast::client
