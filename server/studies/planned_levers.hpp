#pragma once

#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"

namespace dccast::studies {

/// The levers that a plan has where a casting is. Tables of a plan may be against cast length,
/// which is the integral of the measured speed; where the speed was not measured, of the planned
/// one.
class PlannedLevers {
public:
  explicit PlannedLevers(const v1::Schedule& plan) : plan_(plan) {}

  /// Goes on to a later reading. The block stands still before zero.
  void follow(const v1::Reading& reading);
  /// The planned levers at the time of the last reading. One that the plan has not is absent.
  v1::Reading levers() const;

private:
  double planned_speed() const;                       ///< [m/s]
  double planned_flow(const v1::Curve& table) const;  ///< [m2/s]

  const v1::Schedule& plan_;
  double time_s_ = 0.0;
  double cast_length_m_ = 0.0;
  double speed_m_per_s_ = 0.0;  ///< measured last, or planned
};

/// How far a casting has been measured, and the levers of its plan at that time.
/// @param plan      complete case
/// @param readings  by time
/// @return          without `following` and `age_s`
v1::CastingNow casting_now(const v1::Case& plan, const std::vector<v1::Reading>& readings);

}  // namespace dccast::studies
