#pragma once

#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// Names of the columns that a list of jobs may have.
std::vector<std::string> job_columns();

/// A table of jobs. Nothing in it is cut.
/// @param columns  of job_columns(); empty: those that most lists need, and of curl, findings and
///                 labels those that a job here has
std::string job_table(const std::vector<v1::Job>& jobs, std::vector<std::string> columns);

}  // namespace dccast::client::render
