#include "core/thermal/surface_shares.hpp"

#include <algorithm>

namespace dccast::thermal {
namespace {

bool against_distance(const Curve& curve) {
  return !curve.empty() && !curve.constant() && curve.abscissa() == Abscissa::distance;
}

void add_kinks(const Curve& curve, std::vector<double>& edges) {
  if (against_distance(curve)) {
    edges.insert(edges.end(), curve.at().begin(), curve.at().end());
  }
}

void add_water(const Water& water, std::vector<double>& edges) {
  edges.push_back(water.from);
  if (water.boiling_follows_flow) edges.push_back(water.from + water.wetting.jet_length);
  add_kinks(water.coefficient, edges);
}

}  // namespace

SideLaws::SideLaws(const CoolingSpec& cooling, const SideInstant& instant)
    : cooling_(cooling), water_runs_(instant.water_runs) {
  add_water(cooling.water, edges_);
  if (cooling.narrow_water) add_water(*cooling.narrow_water, edges_);
  for (const SideZone& zone : cooling.zones) {
    edges_.push_back(zone.from);
    edges_.push_back(zone.to);
    add_kinks(zone.liquid_coefficient, edges_);
    add_kinks(zone.solid_coefficient, edges_);
  }
  std::sort(edges_.begin(), edges_.end());
}

LawAt SideLaws::at(double distance, Face face) const {
  const Water& water = cooling_.water_of(face);
  if (water_runs_[std::size_t(face)] && distance >= water.from)
    return {law_water, against_distance(water.coefficient)};
  for (std::size_t i = 0; i < cooling_.zones.size(); ++i) {
    const SideZone& zone = cooling_.zones[i];
    if (distance < zone.from || distance >= zone.to || zone.face.value_or(face) != face) continue;
    return {static_cast<int>(i),
            against_distance(zone.liquid_coefficient) || against_distance(zone.solid_coefficient)};
  }
  return {law_dry, false};
}

}  // namespace dccast::thermal
