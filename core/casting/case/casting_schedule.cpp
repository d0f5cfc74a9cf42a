#include "core/casting/case/casting_schedule.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/thermal/cooling.hpp"

namespace dccast::casting {

namespace {

bool against_length(const Curve& curve) {
  return curve.abscissa() == Abscissa::cast_length;
}

double value(const Curve& curve, double time, double length) {
  return curve(against_length(curve) ? length : time);
}

/// Integral of a table delayed by `shift`, times a factor, both against time. Exact: between two
/// points of the tables the product is a parabola, which Simpson's rule integrates exactly.
double integral_of_product(const Curve& table, double shift, const Curve& factor, double from,
                           double to) {
  if (factor.constant()) return factor.value().front() * table.integral(from - shift, to - shift);

  std::vector<double> cuts{from, to};
  for (const double point : table.at()) cuts.push_back(point + shift);
  cuts.insert(cuts.end(), factor.at().begin(), factor.at().end());
  std::erase_if(cuts, [=](double t) { return t < from || t > to; });
  std::sort(cuts.begin(), cuts.end());

  const auto product = [&](double t) { return table(t - shift) * factor(t); };
  double sum = 0.0;
  for (std::size_t i = 1; i < cuts.size(); ++i) {
    const double a = cuts[i - 1], b = cuts[i];
    sum += (b - a) / 6.0 * (product(a) + 4.0 * product(0.5 * (a + b)) + product(b));
  }
  return sum;
}

/// A step that ends when the water starts is still dry.
bool runs(const thermal::Water& water, double time) {
  return water.enabled && time > water.start + same_time;
}

/// Ends of the range in which a table is evaluated. @pre its abscissa is time or cast length
std::pair<double, double> range_of(const Curve& curve, const Course& course) {
  if (against_length(curve)) return {0.0, course.cast_length};
  return {course.begin, course.end};
}

bool follows_course(const Curve& curve) {
  return !curve.empty() && !curve.constant() &&
         (curve.abscissa() == Abscissa::time || against_length(curve));
}

}  // namespace

CastingSchedule::CastingSchedule(const Case& c)
    : schedule_(c.schedule),
      step_(c.time.step),
      cooling_(c.cooling),
      frame_interval_(c.output.frame_interval),
      begin_(-c.schedule.hold),
      end_of_casting_(c.time.end),
      end_(c.time.end + c.time.cool_down) {
  // Steps end at every sudden change: start and end, the valves, the mechanics, the full mould, and
  // the points of the step table.
  events_ = {0.0, end_of_casting_, end_};
  for (const thermal::Face face : {thermal::Face::wide, thermal::Face::narrow}) {
    const auto changes = thermal::valve_changes(cooling_.water_of(face), end_);
    events_.insert(events_.end(), changes.begin(), changes.end());
  }

  if (cooling_.second_water) events_.push_back(cooling_.second_water->start);
  if (c.mechanics.enabled) events_.push_back(c.mechanics.start);
  if (schedule_.filling > 0.0) events_.push_back(begin_ + schedule_.filling);
  if (!step_.constant()) events_.insert(events_.end(), step_.at().begin(), step_.at().end());

  std::sort(events_.begin(), events_.end());
}

void CastingSchedule::end_casting(double time) {
  end_ = time + (end_ - end_of_casting_);
  end_of_casting_ = time;
  std::erase_if(events_, [&](double event) { return event > time; });
  for (const double event : {end_of_casting_, end_})
    if (events_.empty() || event > events_.back()) events_.push_back(event);
}

bool CastingSchedule::changes_after(double time, double length) const {
  const auto ahead = [&](const Curve& table, double shift = 0.0) {
    if (table.empty() || table.constant()) return false;
    return against_length(table) ? table.at().back() > length : table.at().back() + shift > time;
  };
  for (const thermal::Face face : {thermal::Face::wide, thermal::Face::narrow}) {
    const thermal::Water& water = cooling_.water_of(face);
    if (!water.enabled) continue;
    const double last_pulse = water.pulse_period > 0.0 ? water.pulse_end : 0.0;
    if (std::max(water.start, last_pulse) > time || ahead(water.temperature) ||
        ahead(water.critical_heat_flux_factor))
      return true;
  }
  if (cooling_.second_water &&
      (cooling_.second_water->start > time || ahead(schedule_.second_water_flow)))
    return true;
  return ahead(schedule_.casting_speed, schedule_.casting_speed_shift) ||
         ahead(schedule_.casting_speed_factor) || ahead(schedule_.casting_temperature) ||
         ahead(schedule_.water_flow, schedule_.water_flow_shift) ||
         ahead(schedule_.narrow_water_flow, schedule_.water_flow_shift) ||
         ahead(schedule_.water_flow_factor) || ahead(schedule_.metal_level);
}

bool CastingSchedule::cools_down(double time) const {
  return end_ > end_of_casting_ && time >= end_of_casting_ - same_time;
}

double CastingSchedule::planned_speed(double time, double length) const {
  return value(schedule_.casting_speed_factor, time, length) *
         value(schedule_.casting_speed, time - schedule_.casting_speed_shift, length);
}

bool CastingSchedule::speed_follows_time() const {
  return !against_length(schedule_.casting_speed) &&
         !against_length(schedule_.casting_speed_factor);
}

double CastingSchedule::cast_length(double length, double time, double step) const {
  // Not cut by rounding: steps end at the end of the casting.
  double to = time + step;
  if (to > end_of_casting_ + same_time) to = end_of_casting_;
  if (measured_.empty()) return planned_length(length, time, to);

  for (const LeverStretch& stretch : measured_.stretches(Lever::casting_speed, time, to))
    length = stretch.integral ? length + *stretch.integral
                              : planned_length(length, stretch.from, stretch.to);
  return length;
}

double CastingSchedule::planned_length(double length, double from, double to) const {
  if (to <= std::max(from, 0.0)) return length;
  from = std::max(from, 0.0);
  const double h = to - from;

  if (speed_follows_time()) {
    return length + integral_of_product(schedule_.casting_speed, schedule_.casting_speed_shift,
                                        schedule_.casting_speed_factor, from, to);
  }

  // Classical Runge-Kutta for a speed against cast length, perhaps with a factor against time.
  const double k1 = planned_speed(from, length);
  const double k2 = planned_speed(from + 0.5 * h, length + 0.5 * h * k1);
  const double k3 = planned_speed(from + 0.5 * h, length + 0.5 * h * k2);
  const double k4 = planned_speed(to, length + h * k3);
  return length + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

double CastingSchedule::cast_length_over(double length, double time, double to,
                                         std::int64_t most_pieces) const {
  const std::int64_t pieces = speed_follows_time() ? 1 : most_pieces;
  const double piece = (to - time) / static_cast<double>(pieces);
  for (std::int64_t i = 0; i < pieces; ++i)
    length = cast_length(length, time + static_cast<double>(i) * piece, piece);
  return length;
}

double CastingSchedule::filled_share(double time) const {
  if (time >= begin_ + schedule_.filling - same_time) return 1.0;
  return (time - begin_) / schedule_.filling;
}

double CastingSchedule::casting_temperature(double time, double length) const {
  const auto measured = measured_.at(Lever::casting_temperature, time);
  return measured ? *measured : value(schedule_.casting_temperature, time, length);
}

double CastingSchedule::water_flow(double time, double length) const {
  const auto measured = measured_.at(Lever::water_flow, time);
  return measured ? *measured : planned_flow(schedule_.water_flow, cooling_.water, time, length);
}

double CastingSchedule::narrow_water_flow(double time, double length) const {
  // Who measures one flow measures that of all faces, as long as the plan has one for all.
  auto measured = measured_.at(Lever::narrow_water_flow, time);
  const Curve& own = schedule_.narrow_water_flow;
  if (!measured && own.empty()) measured = measured_.at(Lever::water_flow, time);
  return measured ? *measured
                  : planned_flow(own.empty() ? schedule_.water_flow : own,
                                 cooling_.water_of(thermal::Face::narrow), time, length);
}

double CastingSchedule::planned_flow(const Curve& table, const thermal::Water& water, double time,
                                     double length) const {
  const bool on = runs(water, time) && time <= end_of_casting_ + same_time;
  return on ? value(schedule_.water_flow_factor, time, length) *
                  value(table, time - schedule_.water_flow_shift, length)
            : 0.0;
}

double CastingSchedule::second_water_flow(double time, double length) const {
  if (!cooling_.second_water) return 0.0;
  if (const auto measured = measured_.at(Lever::second_water_flow, time)) return *measured;
  const bool on =
      time > cooling_.second_water->start + same_time && time <= end_of_casting_ + same_time;
  return on ? value(schedule_.second_water_flow, time, length) : 0.0;
}

double CastingSchedule::water_temperature(thermal::Face face, double time, double length) const {
  const auto measured = measured_.at(Lever::water_temperature, time);
  return measured ? *measured : value(cooling_.water_of(face).temperature, time, length);
}

double CastingSchedule::critical_heat_flux_factor(thermal::Face face, double time,
                                                  double length) const {
  return value(cooling_.water_of(face).critical_heat_flux_factor, time, length);
}

double CastingSchedule::metal_level(double time, double length) const {
  if (time <= same_time) return 0.0;
  const auto measured = measured_.at(Lever::metal_level, time);
  if (measured) return *measured;
  return schedule_.metal_level.empty() ? 0.0 : value(schedule_.metal_level, time, length);
}

double CastingSchedule::next_frame(double time) const {
  const double passed = std::floor((time - begin_ + same_time) / frame_interval_);
  const double next = begin_ + (passed + 1.0) * frame_interval_;
  if (end_ == end_of_casting_ || next <= end_of_casting_ + same_time) return next;
  return cools_down(time) ? end_ : end_of_casting_;
}

double CastingSchedule::next_change(double time) const {
  const auto next = std::upper_bound(events_.begin(), events_.end(), time + same_time);
  return next == events_.end() ? INFINITY : *next;
}

double CastingSchedule::next_event(double time) const {
  const double change = next_change(time);
  return change == INFINITY ? change : std::min(change, next_frame(time));
}

double CastingSchedule::step_at(double time) const {
  constexpr double growth = 0.02;  // [1] of the time in which the slab has cooled down
  double wanted = step_(time);
  if (cools_down(time)) wanted = std::max(wanted, growth * (time - end_of_casting_));
  const double left = next_event(time) - time;
  if (left <= wanted * (1.0 + same_time)) return left;
  return left < 2.0 * wanted ? 0.5 * left : wanted;
}

// Fewer steps than this are counted one by one, exactly as in the run.
constexpr std::int64_t fewest_in_a_leap = 200;

/// Skips all frames up to the next change if the step is constant: each then takes as many steps as
/// the first.
std::optional<Leap> CastingSchedule::leap_over_frames(double time) const {
  const double change = next_change(time);
  const double to_frame = next_frame(time) - time;
  if (change == INFINITY || step_.derivative(time + same_time) != 0.0) return std::nullopt;
  if (to_frame < frame_interval_ - same_time) return std::nullopt;  // not at a frame

  const double frames = std::floor((change - time) / frame_interval_ - same_time);
  if (frames < 2.0) return std::nullopt;

  const double steps_per_frame = std::ceil(frame_interval_ / step_(time) - same_time);
  const double steps = std::min(frames * std::max(steps_per_frame, 1.0), 1e15);
  if (steps <= static_cast<double>(fewest_in_a_leap)) return std::nullopt;
  return Leap{static_cast<std::int64_t>(steps), time + frames * frame_interval_};
}

Leap CastingSchedule::leap(double time) const {
  constexpr double last_steps = 4.0;  // before an event, where the remainder is halved
  const Leap single_step{1, time + step_at(time)};
  if (cools_down(time)) return single_step;
  if (const auto frames = leap_over_frames(time)) return *frames;

  const double step = step_(time), slope = step_.derivative(time + same_time);
  const double next = next_event(time);
  if (next == INFINITY || slope <= -1.0) return single_step;

  const double largest = std::max(step, step + slope * (next - time));
  const double distance = next - time - last_steps * largest;
  if (distance <= static_cast<double>(fewest_in_a_leap) * largest) return single_step;

  // A step that is linear in time makes the steps a geometric series with the ratio 1 + slope.
  const double growth = std::log1p(slope);
  const double count =
      std::floor(growth == 0.0 ? distance / step : std::log1p(slope * distance / step) / growth);
  if (!(count < 1e15)) return {std::int64_t(1e15), next};
  const double covered = growth == 0.0 ? count * step : step * std::expm1(count * growth) / slope;
  return {static_cast<std::int64_t>(count), time + covered};
}

Course course_of(const Case& c) {
  const CastingSchedule schedule(c);
  Course course{schedule.begin(), schedule.end(),
                schedule.cast_length_over(0.0, 0.0, schedule.end(), 1000), c.section.initial_depth};
  if (c.section.growth)
    course.depth += course.cast_length + schedule.metal_level(c.time.end, course.cast_length);
  return course;
}

std::vector<double> values_in(const Curve& curve, const Course& course) {
  if (!follows_course(curve)) return curve.value();
  const auto [from, to] = range_of(curve, course);
  std::vector<double> values{curve(from), curve(to)};
  for (std::size_t i = 0; i < curve.at().size(); ++i)
    if (curve.at()[i] > from && curve.at()[i] < to) values.push_back(curve.value()[i]);
  return values;
}

bool never_reached(const Curve& curve, const Course& course, double shift) {
  if (!follows_course(curve)) return false;
  const auto [from, to] = range_of(curve, course);
  if (curve.abscissa() != Abscissa::time) shift = 0.0;
  return curve.at().front() + shift >= to || curve.at().back() + shift <= from;
}

std::string listed(const std::vector<std::string>& texts) {
  constexpr std::size_t most = 5;
  std::string list;
  for (std::size_t i = 0; i < std::min(most, texts.size()); ++i)
    list += fmt::format("{}{}", list.empty() ? "" : ", ", texts[i]);
  if (texts.size() > most) list += fmt::format(" and {} more", texts.size() - most);
  return list;
}

}  // namespace dccast::casting
