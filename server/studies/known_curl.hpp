#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/statistics/innovations.hpp"
#include "core/statistics/trajectory_forecast.hpp"
#include "dccast/v1/follow.pb.h"
#include "server/levers/levers_off_plan.hpp"
#include "server/studies/curl_prior.hpp"
#include "server/studies/executed_levers.hpp"
#include "server/studies/forecast_basis.hpp"
#include "server/studies/wrong_gauge.hpp"

namespace dccast::studies {

/// What all readings of a gauge tell.
struct LearnedCurl {
  statistics::TrajectoryForecast forecast;
  std::vector<statistics::Innovation> innovations;  ///< one for each reading
  std::vector<statistics::Departure> departures;    ///< by time
};

/// What is known of the curl at a gauge. Trajectories are those of the casting with its levers as
/// planned: what the executed levers did is taken from each reading, and given to each forecast.
class KnownCurl {
public:
  /// Learns from all readings. Where the gauge has slipped they are learned once more, with a zero
  /// that is unknown again from there on; otherwise the slip would be taken for curl. Nothing is
  /// learned from a gauge whose scale or sign is wrong. @throws CannotForecast
  KnownCurl(const v1::Gauge& gauge, const ForecastBasis& basis);

  const std::string& monitor() const { return monitor_; }
  const CurlPrior& prior() const { return prior_; }
  /// Has learned nothing.
  const statistics::TrajectoryForecast& before() const { return before_; }
  /// From the start of the block on, as the gauge has shown them.
  const std::vector<CurlReading>& readings() const { return readings_; }
  const LearnedCurl& learned() const { return learned_; }
  const std::optional<WrongGauge>& wrong_gauge() const { return wrong_gauge_; }

  /// Adds to a curl as planned what levers off the plan do at its time, as it is known at an
  /// earlier one. The members have their levers as planned, and scatter otherwise than castings off
  /// the plan. So a minute later their scatter counts once more, times the share by which the
  /// levers have been off.
  statistics::Estimated with_levers(const statistics::Estimated& as_planned, double time_s,
                                    double known_until_s) const;

private:
  std::vector<CurlReading> as_planned() const;

  std::string monitor_;
  ExecutedLevers levers_;
  std::vector<levers::PlanDeparture> off_plan_;  ///< by time
  CurlPrior prior_;
  statistics::TrajectoryForecast before_;
  std::vector<CurlReading> readings_;
  std::optional<WrongGauge> wrong_gauge_;
  LearnedCurl learned_;
};

/// A curl with the band that holds nine of ten.
v1::ExpectedCurl expected_curl(const statistics::Estimated& estimated);

/// Whether a reading is farther from what was expected than any casting shows: it was not learned.
bool is_left_out(const statistics::Innovation& innovation);

/// Makes the zero of the gauge unknown again where the gauge has slipped at a reading.
void loosen_zero_at(double time_s, const std::vector<statistics::Departure>& departures,
                    statistics::TrajectoryForecast& forecast);

}  // namespace dccast::studies
