#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

class Connection;

/// The case of a study as given on the command line.
struct StudyCase {
  std::string file;
  std::vector<std::string> set;  ///< KEY=VALUE
  std::vector<std::string> labels;
};

/// Reads the case and creates a study with the plan that `add_plan` adds to the request. Throws
/// CommandFailed, Interrupted.
/// @return empty if case or plan are rejected; the faults have then been printed
std::optional<v1::Study> create_study(Connection& connection, const StudyCase& base,
                                      const std::function<void(v1::CreateStudyRequest&)>& add_plan);

/// Follows a study to its end and shows its progress on stderr.
/// @param come_back  command that continues to follow it, for the message of Interrupted
void follow_with_progress(Connection& connection, const std::string& id,
                          const std::string& come_back);

}  // namespace dccast::client
