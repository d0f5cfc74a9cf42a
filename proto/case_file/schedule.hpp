#pragma once

#include <vector>

#include "dccast/v1/case.pb.h"

/// What a case plans over time and cast length. This is the law of
/// core/casting/case/casting_schedule.hpp for programs that do not see the core; a test compares
/// the two.
namespace dccast::case_file {

/// Value of a table, linear between its points and constant outside.
/// @param at  [unit of the abscissa]
/// @return    [unit of the curve]
/// @pre       the curve has a value; without abscissae it is constant
double curve_value(const v1::Curve& curve, double at);

/// Whether a table is given against cast length.
bool is_by_length(const v1::Curve& curve);

/// A point of the casting.
struct Instant {
  double time_s = 0.0;         ///< of the case
  double cast_length_m = 0.0;  ///< since the block started
};

/// A table of the schedule with the levers on it. It refers to the case.
struct PlannedQuantity {
  const v1::Curve& table;                                   ///< against time or cast length
  const v1::Curve& factor = v1::Curve::default_instance();  ///< empty: 1
  double shift_s = 0.0;  ///< a table against time comes later by this

  /// Value at an instant [unit of the table]; zero without a table.
  double at(const Instant& instant) const;
  /// Whether table and factor change with the cast length alone.
  bool changes_by_length() const;
};

/// A face of a quarter slab; sections and billets have the wide one.
enum class Face { wide, narrow };

/// The plan of a case. In all functions the block starts at 0 s.
class CastingSchedule {
public:
  /// @param complete  case with its defaults; it must outlive the schedule
  explicit CastingSchedule(const v1::Case& complete);

  double begin_s() const { return -schedule_.hold_s(); }  ///< of the simulation: minus the hold
  double end_s() const { return case_.time().end_s(); }   ///< of the casting
  /// When the metal has risen to its level [s].
  double full_mould_s() const { return begin_s() + schedule_.filling_s(); }
  /// Share of the initial depth that has been poured [1].
  double filled_share(double time_s) const;

  /// What is planned, whether or not the block moves and water runs [m/s, °C, m2/s, °C].
  PlannedQuantity casting_speed() const;
  PlannedQuantity casting_temperature() const;                 ///< of the metal poured [°C]
  PlannedQuantity water_flow(Face face) const;                 ///< [m2/s]
  PlannedQuantity second_water_flow() const;                   ///< of all faces [m2/s]
  PlannedQuantity water_temperature(Face face) const;          ///< [°C]
  PlannedQuantity critical_heat_flux_factor(Face face) const;  ///< [1]
  /// How far the metal level stands above that of the start [m]: 0 until the block starts.
  PlannedQuantity metal_level() const;
  /// Whether the narrow face of a quarter slab has a flow or a water line of its own.
  bool has_narrow_water() const;
  bool has_second_water() const { return case_.cooling().has_second_water(); }
  /// The water of a face, which that of the wide face is where the narrow one has none of its own.
  const v1::Water& water(Face face) const;

  /// Speed [m/s]; zero up to time zero.
  double speed_m_per_s(const Instant& instant) const;
  /// Flow of a face [m2/s], zero up to the start of the water and after the end of the casting; for
  /// pulsed water the flow while the valve is open.
  double flow_m2_per_s(Face face, const Instant& instant) const;
  double second_flow_m2_per_s(const Instant& instant) const;  ///< of cooling.second_water
  /// Whether the valve of a face is open; each pulse begins with its open part.
  bool valve_is_open(Face face, double time_s) const;

  /// Cast length at a time [m].
  double cast_length_m(double time_s) const;
  double cast_length_at_end_m() const { return cast_length_m(end_s()); }
  /// Time at which a length is cast, also one after the end [s]; infinite if not within 10 h.
  double time_of_cast_length_s(double length_m) const;

  /// Instants by time that show every bend and jump of the plan, from the hold to the end of the
  /// casting and of the tables, with evenly spaced ones in between.
  std::vector<Instant> instants() const;

private:
  /// Where the tables bend [s, m], ascending.
  struct Bends {
    std::vector<double> time_s, length_m;

    void add(const PlannedQuantity& quantity);
    void sort();
  };

  /// Whether water that starts at a time [s] runs. A step that ends when it starts is still dry.
  bool runs(double start_s, const Instant& instant) const;
  double length_after(const Instant& now, double step_s, double bend_m) const;
  /// Goes on to a time or a cast length, whichever comes first, as if the casting had no end.
  Instant advance(Instant now, double time_s, double length_m) const;
  /// Times at which a valve opens or closes [s].
  std::vector<double> valve_changes(Face face) const;

  const v1::Case& case_;
  const v1::Schedule& schedule_;
  Bends speed_bends_;
};

}  // namespace dccast::case_file
