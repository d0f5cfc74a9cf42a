#pragma once

#include <deque>
#include <utility>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"
#include "server/levers/lever_watch.hpp"

namespace dccast::levers {

/// How far a casting has been measured, and the levers of its plan at that time. It keeps the last
/// readings alone, so that its memory does not grow with the casting.
class CastingProgress {
public:
  /// @param plan  complete case
  explicit CastingProgress(v1::Case plan) : watch_(std::move(plan)) {}

  /// Goes on to a later reading, or to the one that closes the record.
  void follow(const v1::Reading& reading);
  /// Without `following` and `age_s`.
  v1::CastingNow now() const;

private:
  LeverWatch watch_;
  std::deque<v1::Reading> last_;  ///< of the last seconds, in which a lever keeps its value
  bool closed_ = false;
};

}  // namespace dccast::levers
