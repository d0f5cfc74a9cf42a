#pragma once

#include <filesystem>

#include "server/jobs/logs/readings_log.hpp"

namespace dccast::jobs {

/// What a job starts beside.
enum class Lane {
  query,     ///< a query that is kept as a job: it starts at once, in addition to all others
  followed,  ///< it follows a casting: it starts in addition to others, up to a number of its own
  job        ///< it takes a place of the executor
};

/// The lane of a job that was not submitted just now: a query of before is a job like others. Looks
/// at the disk.
inline Lane lane_in(const std::filesystem::path& folder) {
  return follows_readings(folder) ? Lane::followed : Lane::job;
}

}  // namespace dccast::jobs
