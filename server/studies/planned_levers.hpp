#pragma once

#include <deque>
#include <utility>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"
#include "proto/case_file/schedule.hpp"

namespace dccast::studies {

/// The levers that a plan has where a casting is. Tables of a plan may be against cast length,
/// which is the integral of the measured speed; where the speed was not measured, of the planned
/// one.
class PlannedLevers {
public:
  /// @param plan  complete; it must outlive the levers
  explicit PlannedLevers(const v1::Case& plan) : plan_(plan) {}

  /// Goes on to a later reading. The block stands still before zero.
  void follow(const v1::Reading& reading);
  /// The planned levers at the time of the last reading. One that the plan has not is absent.
  v1::Reading levers() const;

private:
  case_file::CastingSchedule plan_;
  case_file::Instant now_;
  double speed_m_per_s_ = 0.0;  ///< measured last, or planned
};

/// How far a casting has been measured, and the levers of its plan at that time. It keeps the last
/// readings alone, so that its memory does not grow with the casting.
class CastingProgress {
public:
  /// @param plan  complete case
  explicit CastingProgress(v1::Case plan) : plan_(std::move(plan)) {}
  CastingProgress(const CastingProgress&) = delete;

  /// Goes on to a later reading, or to the one that closes the record.
  void follow(const v1::Reading& reading);
  /// Without `following` and `age_s`.
  v1::CastingNow now() const;

private:
  const v1::Case plan_;
  PlannedLevers planned_{plan_};
  std::deque<v1::Reading> last_;  ///< of the last seconds, in which a lever keeps its value
  bool closed_ = false;
};

}  // namespace dccast::studies
