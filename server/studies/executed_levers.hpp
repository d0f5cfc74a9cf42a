#pragma once

#include <limits>
#include <vector>

#include "core/statistics/trajectory_forecast.hpp"
#include "dccast/v1/job.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// The share of a minute that has passed since another time [s], at most 1: what is known of levers
/// ages as fast.
double minute_share(double time_s, double since_s);

/// What levers that have left the plan did to the curl at a gauge: the curl of the run that follows
/// them minus that of the run of the plan, at equal mesh and data. It is known up to the last step
/// of the run that follows. From there on it is expected to stay, since the levers are expected to
/// return to the plan; how it goes on is uncertain by a share of itself that grows over a minute.
class ExecutedLevers {
public:
  /// The levers are as planned, or it is not known what they did.
  ExecutedLevers() = default;
  ExecutedLevers(const v1::CurlCurve& followed, const v1::CurlCurve& planned);

  /// More curl than planned at a time [m].
  /// @param known_until_s  what the levers do after that is not known yet
  statistics::Estimated effect_at(
      double time_s, double known_until_s = std::numeric_limits<double>::infinity()) const;

private:
  std::vector<double> time_s_;    ///< increasing; empty: no effect
  std::vector<double> effect_m_;  ///< at these times
};

}  // namespace dccast::studies
