#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace dccast::jobs {

/// Processes of one name.
struct ProcessTotals {
  int number = 0;
  std::int64_t resident_bytes = 0;
};

/// The children of this process by their names ("dccast-job"), as the system has them now: the
/// workers it has started, not those that it leads on from an earlier daemon.
std::map<std::string, ProcessTotals> child_processes();

/// Memory that this process has in use [bytes].
std::int64_t own_resident_bytes();

}  // namespace dccast::jobs
