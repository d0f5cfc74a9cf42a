#pragma once

#include "client/connection.hpp"
#include "client/study.hpp"

namespace dccast::client {

/// The jobs of a study, oldest first; empty for an unknown study.
std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id);

/// Results of a study so far. Throws CommandFailed.
v1::StudyResult evaluate_study(Connection& connection, const std::string& id, bool curves = false);

/// A refinement study with its jobs. Throws CommandFailed, also for a study of another kind.
Study read_study(Connection& connection, const std::string& id);

/// The refinement study to which a job belongs; an empty one if it belongs to none.
Study study_around(Connection& connection, const v1::Job& job);

}  // namespace dccast::client
