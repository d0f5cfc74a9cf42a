#include "proto/values/plant_units.hpp"

#include <algorithm>
#include <array>

namespace dccast::values {
namespace {

struct Row {
  std::string_view si;
  PlantUnit plant;
};

constexpr std::array rows{
    Row{"1", {"%", 1e2}},
    Row{"m", {"mm", 1e3}},
    Row{"m2", {"dm2", 1e2}},
    Row{"m/s", {"mm/min", 60e3}},
    Row{"m2/s", {"l/min/m", 60e3}},
    Row{"m/s2", {"mm/min2", 3.6e6}},
    Row{"m2/s2", {"l/min2/m", 3.6e6}},
    Row{"W", {"kW", 1e-3}},
    Row{"W/m", {"kW/m", 1e-3}},
    Row{"J", {"MJ", 1e-6}},
    Row{"J/m", {"MJ/m", 1e-6}},
    Row{"Pa", {"kPa", 1e-3}},
    Row{"degC", {"°C", 1.0}},
};

}  // namespace

PlantUnit plant_unit(std::string_view si) {
  const auto found = std::ranges::find(rows, si, &Row::si);
  return found == rows.end() ? PlantUnit{si, 1.0} : found->plant;
}

}  // namespace dccast::values
