#pragma once

#include <map>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"

namespace dccast::levers {

/// What the levers of a casting can be, judged by its alloy and its plan. Names of levers are
/// fields of v1::Reading, values have the unit in the name.
///
/// Metal that flows is not below its solidus, and no furnace is 150 K above plan and liquidus. No
/// pump and no drive reaches four times the largest value of the plan. A lever that is too low may
/// be one that really fell, so that it counts (levers_off_plan.hpp).
class SoundLevers {
public:
  /// @param plan  complete
  explicit SoundLevers(const v1::Case& plan);

  /// What is permitted, for a value that is not; empty: it is, or the plan does not tell.
  std::string limit_passed(const std::string& lever, double value) const;
  /// The mistake of unit, scale or sign with which a value would be as planned, such as "; if the
  /// sensor shows K, it is 680 degC"; empty: none.
  std::string explanation(const std::string& lever, double value) const;

private:
  struct Range {
    double lowest = 0.0, highest = 0.0;  ///< permitted
    std::string reason;                  ///< of the limits
    double least_planned = 0.0, most_planned = 0.0;
  };

  std::map<std::string, Range> ranges_;  ///< of the levers that the plan has
};

/// A scale or a sign by which a sensor may be wrong.
struct WrongScale {
  double factor;                ///< what is shown over what is true
  const char* text;             ///< for people: "the sign is turned"
  bool of_rates_alone = false;  ///< no gauge of a length has it
};

/// Scales of sensors, plants' usual mistakes first.
const std::vector<WrongScale>& wrong_scales();

}  // namespace dccast::levers
