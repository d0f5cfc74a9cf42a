#pragma once

#include <map>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// The jobs that were submitted for one level of a study, by their request ids: STUDY/REFINEMENT,
/// and STUDY/REFINEMENT/2, /3, ... for those that replace one that was lost.
struct LevelAttempts {
  std::map<int, v1::Job> by_number;  ///< first attempt is 1; deleted ones are missing

  /// The one that counts: the last that is waiting, running or has succeeded; else the last. Null
  /// when there is none.
  const v1::Job* current() const;
  /// Whether the level is lost and doing it again can help: it was cancelled, or it failed for a
  /// cause that is not the case's own. What the same case must end in again is left as it is.
  bool can_be_repaired() const;
  int next_number() const { return by_number.empty() ? 1 : by_number.rbegin()->first + 1; }
};

/// Attempts of every level, by refinement. Jobs with request ids of other forms are left out.
std::map<int, LevelAttempts> attempts_of(const std::string& study,
                                         const std::vector<v1::Job>& jobs);

/// The request id of an attempt; it follows from study, refinement and number alone, so that
/// submitting it twice gives one job.
std::string attempt_request_id(const std::string& study, int refinement, int number);

}  // namespace dccast::client
