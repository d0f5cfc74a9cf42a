#pragma once

#include <optional>
#include <string>

#include "dccast/v1/follow.pb.h"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/line.pb.h"
#include "server/judging/followed_casting.hpp"
#include "server/service/context.hpp"

/// What the readings of a job tell: the curl to come, and what its line learns from it.
namespace dccast::service {

/// Refuses a job that is no live one. @throws Refusal
void require_following(const Context& context, const std::string& id);

/// Adds how far the casting has been measured to a running job that follows one. It is left out,
/// with a line in the log, where the record cannot be read.
void add_casting(Context& context, v1::Job& job);

/// The castings that running jobs follow, for metrics.
struct FollowedCastings {
  int castings = 0;
  int warnings = 0;               ///< in the latest forecast of each
  int levers_off_plan = 0;        ///< now (CastingNow.alarms)
  double oldest_reading_s = 0.0;  ///< longest time since the last reading of a casting arrived
};
FollowedCastings followed_castings(Context& context);

/// Forecasts the casting that a job follows. @throws Refusal
v1::Forecast forecast_job(Context& context, const std::string& id);

/// What was measured and forecast of the casting that a job follows or has followed; empty: it
/// follows none.
std::optional<judging::FollowedCasting> followed_casting(Context& context, const std::string& id);

/// Lets a casting on a line tell its curl while its record is still there. Does not throw.
void learn_before_removal(Context& context, const v1::Job& job) noexcept;

/// A line with what its castings have told, those included that have ended since it was last asked
/// for. @throws Refusal
v1::Line learned_line(Context& context, const std::string& name);

}  // namespace dccast::service
