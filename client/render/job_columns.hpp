#pragma once

#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::client::render {

/// Names of the available columns of a list of jobs.
std::vector<std::string> job_columns();

/// A table of jobs; no text is truncated.
/// @param columns  from job_columns(); empty: the usual ones, plus curl, findings and labels if one
///                 of the jobs has them
std::string job_table(const std::vector<v1::Job>& jobs, std::vector<std::string> columns);

}  // namespace dccast::client::render
