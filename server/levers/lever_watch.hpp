#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/follow.pb.h"
#include "server/levers/planned_levers.hpp"
#include "server/levers/sound_levers.hpp"

namespace dccast::levers {

/// Watches the levers of a casting beside its plan, reading by reading.
///
/// A lever is off where it has been to one side of its plan for 5 s: a speed or a flow by a fifth,
/// the metal by 20 K, the water by 10 K, the level by 10 mm. Water at zero is off in two readings.
/// A coarse counter of the length, which makes the speed jump, is to both sides. The first 10 s do
/// not count: the block gathers speed.
class LeverWatch {
public:
  /// @param plan  complete
  explicit LeverWatch(v1::Case plan);
  LeverWatch(const LeverWatch&) = delete;  // its parts refer to the plan

  /// Goes on to a later reading.
  void follow(const v1::Reading& reading);
  /// The levers of the plan at the time of the last reading.
  v1::Reading planned() const { return planned_.levers(); }
  /// The levers that are off now, the newest last. The `monitor` of each is a lever.
  std::vector<v1::ForecastWarning> under_way() const;
  /// What is to be done first about a finding of a time [s]: the levers that were off there, or
  /// shortly before. Empty: none was.
  std::string remedy_at(double time_s) const;

private:
  struct Alarm {
    std::size_t lever = 0;
    double begin_s = 0.0;         ///< when it was first off
    std::optional<double> end_s;  ///< empty: it still is
    bool is_zero = false;
    v1::ForecastWarning warning{};
    std::string remedy{};
  };
  /// A lever that was measured beside its plan.
  struct Beside {
    double measured = 0.0, planned = 0.0;
    bool is_zero = false;
    int side = 0;  ///< -1, 1: too low, too high; 0: as planned
  };
  /// How long a lever has been off.
  struct Course {
    int side = 0;
    double since_s = 0.0;
    int zeros = 0;  ///< readings in a row
    std::optional<std::size_t> alarm;
  };
  static constexpr std::size_t count = 7;

  std::optional<Beside> beside(std::size_t lever, const v1::Reading& reading,
                               const v1::Reading& planned) const;
  void follow(std::size_t lever, double time_s, const Beside& now);
  void raise(std::size_t lever, double time_s, const Beside& now);

  v1::Case plan_;
  PlannedLevers planned_;
  SoundLevers sound_;
  std::array<Course, count> courses_;
  std::vector<Alarm> alarms_;  ///< in the order in which they were raised
};

/// What a lever was in a casting, beside its plan, as texts with the unit of plants. Readings from
/// 10 s on count.
struct PouredLever {
  std::string name;
  std::string planned, measured;  ///< means over the readings
  std::string range;              ///< of the measured ones
};
/// @param plan  complete
std::vector<PouredLever> poured_levers(const v1::Case& plan,
                                       const std::vector<v1::Reading>& readings);

}  // namespace dccast::levers
