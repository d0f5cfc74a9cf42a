#pragma once

#include <string>

#include "dccast/v1/case.pb.h"
#include "proto/figures/run_history.hpp"

namespace dccast::judging {

/// A run as it is judged: its history, with its case.
struct JudgedRun : figures::RunHistory {
  std::string name;      ///< under which it is shown
  v1::Case description;  ///< with all defaults
  bool failed = false;   ///< it ended before it had a result
};

}  // namespace dccast::judging
