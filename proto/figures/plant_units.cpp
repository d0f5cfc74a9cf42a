#include "proto/figures/plant_units.hpp"

#include <string>

#include "dccast/v1/judgement.pb.h"

namespace dccast::figures {

v1::PlantUnit plant_unit(std::string_view si) {
  const auto& options = v1::Judgement::descriptor()->file()->options();
  for (int i = 0; i < options.ExtensionSize(v1::plant_unit); ++i)
    if (const v1::PlantUnit& unit = options.GetExtension(v1::plant_unit, i); unit.si() == si)
      return unit;

  v1::PlantUnit same;
  same.set_name(std::string(si));
  same.set_factor(1.0);
  return same;
}

}  // namespace dccast::figures
