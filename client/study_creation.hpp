#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

class Connection;

/// The case of a study as a command line names it.
struct StudyCase {
  std::string file;
  std::vector<std::string> set;  ///< KEY=VALUE
  std::vector<std::string> labels;
};

/// Reads the case and creates a study with the plan that `add_plan` puts into the request.
/// @return nothing when case or plan are refused, which is said. Throws CommandFailed, Interrupted.
std::optional<v1::Study> create_study(Connection& connection, const StudyCase& base,
                                      const std::function<void(v1::CreateStudyRequest&)>& add_plan);

/// Follows a study to its end with its progress on stderr.
/// @param come_back  command that takes it up again, for Interrupted
void follow_with_progress(Connection& connection, const std::string& id,
                          const std::string& come_back);

}  // namespace dccast::client
