#pragma once

#include "client/connection.hpp"
#include "client/study.hpp"

namespace dccast::client {

/// The jobs of a study, oldest first; none for a study that nobody has heard of.
std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id);

/// What the jobs of a study say so far.
/// @param like  only runs of this casting, with all its defaults, are levels; null: of that of the
///              oldest job
Study read_study(Connection& connection, const std::string& id, const v1::Case* like = nullptr);

/// The study a job belongs to, judged for its casting; an empty one when it belongs to none.
Study study_around(Connection& connection, const v1::Job& job, const v1::Case& casting);

}  // namespace dccast::client
