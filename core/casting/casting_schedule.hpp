#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "core/casting/case.hpp"

namespace dccast::casting {

/// Steps that follow one another without an event.
struct Leap {
  std::int64_t steps = 1;
  double to = 0.0;  ///< [s]
};

/// What the pit does, as functions of time and of the length cast so far.
class CastingSchedule {
public:
  explicit CastingSchedule(const Case& casting_case);

  /// Time at which the simulation begins, minus the hold [s].
  double begin() const { return begin_; }
  double end() const { return end_; }  ///< [s]

  /// Length cast at the end of a step [m]; nothing is cast before time zero. Exact where the speed
  /// is a table against time, by the classical Runge-Kutta formula where it is one against length.
  double cast_length(double length, double time, double step) const;
  double casting_temperature(double time, double length) const;  ///< [°C]
  /// [m2/s], that of an open valve where it is pulsed; zero before its start.
  double water_flow(double time, double length) const;
  double narrow_water_flow(double time, double length) const;  ///< [m2/s] of the narrow face

  /// First time after another one at which the fields are stored [s].
  double next_frame(double time) const;

  /// Step the case asks for at a time [s], ending at the latest where something changes at once:
  /// the block starts, water starts or its valve moves, mechanics starts, the table of steps has a
  /// point, the simulation ends, and where the fields are to be stored, so that a frame is of
  /// exactly the instant asked for. A remainder below two steps is halved, so that no sliver is
  /// left over.
  double step_at(double time) const;

  /// Many steps at once, without making them: between two events the step is linear in time, so
  /// that times form a geometric series. One step where few are left to the next event.
  Leap leap(double time) const;
  /// Whether cast_length() is exact over any time.
  bool speed_follows_time() const;

private:
  double speed(double time, double length) const;
  double flow(const Curve& table, const thermal::Water& water, double time, double length) const;
  /// Next time at which something changes at once, and the same or the next frame [s]; infinite
  /// after the end.
  double next_change(double time) const;
  double next_event(double time) const;
  std::optional<Leap> leap_over_frames(double time) const;

  Schedule schedule_;
  Curve step_;
  thermal::CoolingSpec cooling_;
  double frame_interval_;       ///< [s]
  double begin_;                ///< [s]
  double end_;                  ///< [s]
  std::vector<double> events_;  ///< [s] increasing
};

}  // namespace dccast::casting
