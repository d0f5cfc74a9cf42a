#pragma once

#include <string>
#include <string_view>

#include "server/jobs/job_store.hpp"
#include "server/jobs/sqlite.hpp"

/// How a job stands in its row of the store.
namespace dccast::jobs {

/// Columns of the table `job`, in the order in which read_row() takes them.
extern const std::string_view job_columns;

JobRecord read_row(const Statement& statement);

/// Binds the columns that change in a job's life, in the order of JobStore::update().
void bind_changing(Statement& statement, const JobRecord& record);

/// The labels of a job, one a line, each between two line ends.
std::string label_lines(const v1::Job& job);

/// A serialised Job with only the changes set.
std::string changes_of(const v1::Job& job);

}  // namespace dccast::jobs
