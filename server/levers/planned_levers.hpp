#pragma once

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"
#include "proto/case_file/schedule.hpp"

namespace dccast::levers {

/// In the first seconds the block gathers speed: levers beside their plan count from then on [s].
inline constexpr double gathers_speed_s = 10.0;

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
  v1::Reading seen_;            ///< levers that the plant measures
};

}  // namespace dccast::levers
