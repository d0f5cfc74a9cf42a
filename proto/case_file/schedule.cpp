#include "proto/case_file/schedule.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "proto/values/interpolation.hpp"

namespace dccast::case_file {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double same_time_s = 1e-9;     // as in core/casting/case/casting_schedule.hpp
constexpr double longest_s = 36000.0;    // limit of the search for a cast length
constexpr double longest_step_s = 0.25;  // where the speed depends on the length
constexpr double beside_jump_s = 1e-6;   // from an instant before a jump to the jump
constexpr double most_valve_changes = 2000.0;

double value_at(const v1::Curve& curve, const Instant& instant, double shift_s, double otherwise) {
  if (curve.value().empty()) return otherwise;
  return curve_value(curve, is_by_length(curve) ? instant.cast_length_m : instant.time_s - shift_s);
}

/// The first of some places that lies beyond another one; infinite if there is none.
double next_beyond(const std::vector<double>& places, double place) {
  const auto next = std::upper_bound(places.begin(), places.end(), place);
  return next == places.end() ? infinite : *next;
}

}  // namespace

double curve_value(const v1::Curve& curve, double at) {
  const int count = std::min(curve.at_size(), curve.value_size());
  if (count == 0) return curve.value(0);
  const auto size = static_cast<std::size_t>(count);
  return values::interpolate({curve.at().data(), size}, {curve.value().data(), size}, at);
}

bool is_by_length(const v1::Curve& curve) {
  return curve.abscissa() == v1::CAST_LENGTH;
}

double PlannedQuantity::at(const Instant& instant) const {
  return value_at(factor, instant, 0.0, 1.0) * value_at(table, instant, shift_s, 0.0);
}

bool PlannedQuantity::changes_by_length() const {
  const auto is_constant = [](const v1::Curve& curve) { return curve.at_size() < 2; };
  if (is_constant(table) && is_constant(factor)) return false;
  return (is_constant(table) || is_by_length(table)) &&
         (is_constant(factor) || is_by_length(factor));
}

void CastingSchedule::Bends::add(const PlannedQuantity& quantity) {
  const auto add_curve = [this](const v1::Curve& curve, double shift_s) {
    if (curve.at_size() < 2) return;
    for (const double at : curve.at())
      is_by_length(curve) ? length_m.push_back(at) : time_s.push_back(at + shift_s);
  };
  add_curve(quantity.table, quantity.shift_s);
  add_curve(quantity.factor, 0.0);
}

void CastingSchedule::Bends::sort() {
  std::sort(time_s.begin(), time_s.end());
  std::sort(length_m.begin(), length_m.end());
}

CastingSchedule::CastingSchedule(const v1::Case& complete)
    : case_(complete), schedule_(complete.schedule()) {
  speed_bends_.add(casting_speed());
  speed_bends_.sort();
}

double CastingSchedule::filled_share(double time_s) const {
  if (time_s >= full_mould_s() - same_time_s) return 1.0;
  return (time_s - begin_s()) / schedule_.filling_s();
}

PlannedQuantity CastingSchedule::casting_speed() const {
  return {schedule_.casting_speed_m_per_s(), schedule_.casting_speed_factor(),
          schedule_.casting_speed_shift_s()};
}

PlannedQuantity CastingSchedule::casting_temperature() const {
  return {schedule_.casting_temperature_c()};
}

PlannedQuantity CastingSchedule::water_flow(Face face) const {
  const bool narrow = face == Face::narrow && schedule_.has_narrow_water_flow_m2_per_s();
  return {narrow ? schedule_.narrow_water_flow_m2_per_s() : schedule_.water_flow_m2_per_s(),
          schedule_.water_flow_factor(), schedule_.water_flow_shift_s()};
}

PlannedQuantity CastingSchedule::second_water_flow() const {
  return {schedule_.second_water_flow_m2_per_s()};
}

PlannedQuantity CastingSchedule::water_temperature(Face face) const {
  return {water(face).temperature_c()};
}

PlannedQuantity CastingSchedule::critical_heat_flux_factor(Face face) const {
  return {water(face).critical_heat_flux_factor()};
}

PlannedQuantity CastingSchedule::metal_level() const {
  return {schedule_.metal_level_m()};
}

bool CastingSchedule::has_narrow_water() const {
  return case_.section().kind() == v1::Section::QUARTER_SLAB &&
         (schedule_.has_narrow_water_flow_m2_per_s() || case_.cooling().has_narrow_water());
}

const v1::Water& CastingSchedule::water(Face face) const {
  const v1::Cooling& cooling = case_.cooling();
  return face == Face::narrow && cooling.has_narrow_water() ? cooling.narrow_water()
                                                            : cooling.water();
}

double CastingSchedule::speed_m_per_s(const Instant& instant) const {
  return instant.time_s > same_time_s ? casting_speed().at(instant) : 0.0;
}

bool CastingSchedule::runs(double start_s, const Instant& instant) const {
  return instant.time_s > start_s + same_time_s && instant.time_s <= end_s() + same_time_s;
}

double CastingSchedule::flow_m2_per_s(Face face, const Instant& instant) const {
  const v1::Water& of_face = water(face);
  return of_face.enabled() && runs(of_face.start_s(), instant) ? water_flow(face).at(instant) : 0.0;
}

double CastingSchedule::second_flow_m2_per_s(const Instant& instant) const {
  return has_second_water() && runs(case_.cooling().second_water().start_s(), instant)
             ? second_water_flow().at(instant)
             : 0.0;
}

bool CastingSchedule::valve_is_open(Face face, double time_s) const {
  const v1::Water& of_face = water(face);
  if (!of_face.enabled() || time_s <= of_face.start_s()) return false;
  if (of_face.pulse_period_s() <= 0.0 || time_s >= of_face.pulse_end_s()) return true;

  const double since_opening_s = std::fmod(time_s - of_face.start_s(), of_face.pulse_period_s());
  return since_opening_s < of_face.pulse_share() * of_face.pulse_period_s();
}

/// Classical Runge-Kutta; for a speed against time this is Simpson's rule, which is exact between
/// two bends: a table times a factor is a parabola there. Beyond the next bend the speed is that at
/// the bend, so that the length grows evenly with the step.
double CastingSchedule::length_after(const Instant& now, double step_s, double bend_m) const {
  const PlannedQuantity speed = casting_speed();
  const double half_s = 0.5 * step_s;
  const auto speed_at = [&](double after_s, double moved_m) {
    return speed.at({now.time_s + after_s, std::min(now.cast_length_m + moved_m, bend_m)});
  };

  const double k1 = speed_at(0.0, 0.0);
  const double k2 = speed_at(half_s, half_s * k1);
  const double k3 = speed_at(half_s, half_s * k2);
  const double k4 = speed_at(step_s, step_s * k3);
  return now.cast_length_m + step_s / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

Instant CastingSchedule::advance(Instant now, double time_s, double length_m) const {
  if (time_s <= 0.0) return {time_s, now.cast_length_m};
  now.time_s = std::max(now.time_s, 0.0);
  const double step_s = speed_bends_.length_m.empty() ? infinite : longest_step_s;

  while (now.time_s < time_s) {
    // A step ends at the next bend, so that the speed is smooth in it.
    const double to_s =
        std::min({time_s, next_beyond(speed_bends_.time_s, now.time_s), now.time_s + step_s});
    const double to_m = std::min(next_beyond(speed_bends_.length_m, now.cast_length_m), length_m);
    const double reached_m = length_after(now, to_s - now.time_s, to_m);
    if (reached_m < to_m) {
      now = {to_s, reached_m};
      continue;
    }

    double shorter_s = 0.0, longer_s = to_s - now.time_s;
    for (int halvings = 0; halvings < 60; ++halvings) {
      const double middle_s = 0.5 * (shorter_s + longer_s);
      (length_after(now, middle_s, to_m) < to_m ? shorter_s : longer_s) = middle_s;
    }
    now = {now.time_s + longer_s, to_m};
    if (to_m >= length_m) return now;
  }
  return now;
}

double CastingSchedule::cast_length_m(double time_s) const {
  return advance({}, std::min(time_s, end_s()), infinite).cast_length_m;
}

double CastingSchedule::time_of_cast_length_s(double length_m) const {
  const Instant reached = advance({}, longest_s, length_m);
  return reached.cast_length_m < length_m ? infinite : reached.time_s;
}

std::vector<double> CastingSchedule::valve_changes(Face face) const {
  const v1::Water& of_face = water(face);
  const double start_s = of_face.start_s(), period_s = of_face.pulse_period_s();
  std::vector<double> times{start_s};
  const double last_s = std::min(of_face.pulse_end_s(), end_s());
  if (period_s <= 0.0 || last_s <= start_s) return times;
  if (2.0 * (last_s - start_s) / period_s > most_valve_changes) return times;

  for (double opens_s = start_s; opens_s < last_s; opens_s += period_s)
    times.insert(times.end(), {opens_s, opens_s + of_face.pulse_share() * period_s});
  std::erase_if(times, [last_s](double time_s) { return time_s >= last_s; });
  times.push_back(last_s);
  return times;
}

std::vector<Instant> CastingSchedule::instants() const {
  Bends bends;
  for (const PlannedQuantity& quantity :
       {casting_speed(), water_flow(Face::wide), water_flow(Face::narrow), second_water_flow(),
        water_temperature(Face::wide), water_temperature(Face::narrow),
        critical_heat_flux_factor(Face::wide), critical_heat_flux_factor(Face::narrow),
        metal_level()})
    bends.add(quantity);
  std::vector<double> times = bends.time_s;
  for (const double length_m : bends.length_m) times.push_back(time_of_cast_length_s(length_m));

  std::vector<double> jumps{0.0, end_s()};
  for (const Face face : {Face::wide, Face::narrow}) {
    const std::vector<double> changes = valve_changes(face);
    jumps.insert(jumps.end(), changes.begin(), changes.end());
  }
  if (has_second_water()) jumps.push_back(case_.cooling().second_water().start_s());
  for (const double jump_s : jumps)
    times.insert(times.end(), {jump_s - beside_jump_s, jump_s, jump_s + beside_jump_s});

  std::erase_if(times, [&](double time_s) { return !(time_s > begin_s() && time_s < infinite); });
  times.push_back(begin_s());
  const double last_s = *std::ranges::max_element(times);
  constexpr int pieces = 100;  // where a product of tables is curved
  for (int i = 1; i < pieces; ++i) times.push_back(begin_s() + (last_s - begin_s()) * i / pieces);
  std::sort(times.begin(), times.end());
  times.erase(std::unique(times.begin(), times.end()), times.end());

  std::vector<Instant> instants;
  Instant now;
  for (const double time_s : times) instants.push_back(now = advance(now, time_s, infinite));
  return instants;
}

}  // namespace dccast::case_file
