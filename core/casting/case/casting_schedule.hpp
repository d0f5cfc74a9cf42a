#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/casting/case/case.hpp"
#include "core/casting/case/lever_record.hpp"

namespace dccast::casting {

/// Times closer than this are equal: steps are sums of decimal fractions [s].
inline constexpr double same_time = 1e-9;

/// A sequence of steps without an event in between.
struct Leap {
  /// Number of steps.
  std::int64_t steps = 1;
  double to = 0.0;  ///< [s] time at its end
};

/// The operating conditions of the casting as functions of time and cast length: those that the
/// case plans and, of a casting under way, those that were measured up to the last reading.
/// Clients have the plan from proto/case_file/schedule.hpp; a test compares both.
///
/// Units: in all functions time [s] and (cast) length [m].
class CastingSchedule {
public:
  /// @param casting_case  checked; its tables are copied
  explicit CastingSchedule(const Case& casting_case);

  /// Adds what was measured: from now on it holds wherever it is known.
  /// @throws std::invalid_argument  the reading is not later than the last one
  void append(const LeverReading& reading) { measured_.append(reading); }

  /// Start of the simulation: minus the hold [s].
  double begin() const { return begin_; }
  double end() const { return end_; }  ///< [s] of the simulation, the cool-down included
  /// End of the casting [s]: from then on nothing is poured, and no water runs.
  double end_of_casting() const { return end_of_casting_; }

  /// Ends the casting at a time before its planned end; the cool-down follows.
  void end_casting(double time);
  /// Whether speed, metal, level, water, valves or pulses change later by the plan.
  bool changes_after(double time, double length) const;
  /// Whether a casting is under way, of which levers are measured.
  bool is_followed() const { return !measured_.empty(); }

  /// Cast length at the end of a step [m]; zero before time zero. Exact if the speed is tabulated
  /// against time; integrated by the classical Runge-Kutta method if it is tabulated against
  /// length.
  /// @param length  at the beginning of the step [m]
  /// @param time    at the beginning of the step [s]
  /// @param step    length of the time step [s]
  double cast_length(double length, double time, double step) const;
  /// Speed by the plan [m/s], whether or not the block moves.
  double planned_speed(double time, double length) const;
  /// Share of the initial depth that has been poured [1].
  double filled_share(double time) const;
  double casting_temperature(double time, double length) const;  ///< [°C]
  /// [m2/s], zero before the water starts; for pulsed water the flow while the valve is open.
  double water_flow(double time, double length) const;
  double narrow_water_flow(double time, double length) const;  ///< [m2/s] on the narrow face
  double second_water_flow(double time, double length) const;  ///< [m2/s], zero before its start
  double water_temperature(thermal::Face face, double time, double length) const;  ///< [°C]
  double critical_heat_flux_factor(thermal::Face face, double time, double length) const;  ///< [1]
  /// How far the metal level stands above that of the start [m]; zero until the block starts.
  double metal_level(double time, double length) const;

  /// First time after `time` at which the fields are stored [s].
  double next_frame(double time) const;

  /// Time step requested by the case at a time [s]. It never goes beyond the next event: start of
  /// the block, start of the water or switching of its valve, start of the mechanics, a point of
  /// the step table, the end of the simulation, or the time of a frame, so that a frame shows
  /// exactly the requested time. If less than two steps remain up to the event, the remainder is
  /// halved, so that no very short step is left. While the slab cools down steps grow with the time
  /// since the end of the casting, and there is one frame, at the end.
  double step_at(double time) const;

  /// Counts many steps at once without simulating them: between two events the step is linear in
  /// time, so the step times form a geometric series. A single step if only few are left to the
  /// next event.
  Leap leap(double time) const;
  /// Whether the speed is tabulated against time only, so that cast_length() is exact for any step.
  bool speed_follows_time() const;
  /// cast_length() over a period of any length, whose steps are not known one by one.
  /// @param most_pieces  for a speed against cast length; others are exact in one piece
  double cast_length_over(double length, double time, double to, std::int64_t most_pieces) const;

private:
  /// Cast length at the end of a period by the plan [m].
  double planned_length(double length, double from, double to) const;
  bool cools_down(double time) const;
  /// [m2/s]
  double planned_flow(const Curve& table, const thermal::Water& water, double time,
                      double length) const;
  /// Time of the next sudden change [s], and of the next sudden change or frame [s]; infinite after
  /// the end.
  double next_change(double time) const;
  /// Next time at which something changes at once, such as a valve or the end of the hold [s].
  double next_event(double time) const;
  /// Skips all frames up to the next change if the step is constant; absent otherwise.
  std::optional<Leap> leap_over_frames(double time) const;

  Schedule schedule_;
  Curve step_;
  thermal::CoolingSpec cooling_;
  double frame_interval_;       ///< [s]
  double begin_;                ///< [s]
  double end_of_casting_;       ///< [s]
  double end_;                  ///< [s] with the cool-down
  std::vector<double> events_;  ///< [s] increasing
  LeverRecord measured_;
};

/// The ranges of time, cast length and depth that a casting passes through.
struct Course {
  double begin = 0.0;        ///< [s]
  double end = 0.0;          ///< [s]
  double cast_length = 0.0;  ///< [m] at the end
  double depth = 0.0;        ///< [m] of the metal at the end
};

/// The course of a case from its first to its last step.
Course course_of(const Case& casting_case);

/// The values that a table takes during the course: at both ends of the range and at the points in
/// between.
/// @param curve  against time [s] or cast length [m]; of other tables all values are returned
/// @return       [unit of the curve]
std::vector<double> values_in(const Curve& curve, const Course& course);

/// Whether a table never takes effect: all its points lie before or after the course, so that one
/// value holds throughout. False for constants and for tables against anything but time and cast
/// length.
/// @param shift  [s] delay of a table against time
bool never_reached(const Curve& curve, const Course& course, double shift = 0.0);

/// Joins texts; of a long list only the first ones: "a, b, c and 12 more".
std::string listed(const std::vector<std::string>& texts);

}  // namespace dccast::casting
