#include "core/thermal/surface_cooling.hpp"

#include <algorithm>

namespace dccast::thermal {
namespace {

using material::ThermalState;

double water_flow_of(Face face, const HeatStepInput& input) {
  return face == Face::narrow ? input.narrow_water_flow.value_or(input.water_flow)
                              : input.water_flow;
}

SurfaceState surface_of(const ThermalState& state) {
  return {state.temperature, state.liquid_fraction};
}

}  // namespace

void SurfaceCooling::resize(std::size_t nodes) {
  flux_.assign(nodes, 0.0);
  flux_derivative_.assign(nodes, 0.0);
}

void SurfaceCooling::begin_step(const HeatForms& forms,
                                const material::ThermalProperties& properties,
                                const HeatField& field, const HeatStepInput& input) {
  forms.divide_side(cooling_,
                    {input.metal_level,
                     {water_runs(Face::wide, input), water_runs(Face::narrow, input)},
                     input.rise},
                    side_);
  for (const Face face : {Face::wide, Face::narrow}) {
    boiling_[std::size_t(face)] =
        boiling_of(cooling_.water_of(face), water_flow_of(face, input), input.time);
  }
  film_share_.clear();
  for (const SideShare& share : side_)
    film_share_.push_back(share.law == law_water ? film_share_of(share, properties, field) : 0.0);
}

double SurfaceCooling::film_share_of(const SideShare& share,
                                     const material::ThermalProperties& properties,
                                     const HeatField& field) const {
  const std::size_t node = std::size_t(share.node);
  return film_share(cooling_.water_of(share.face), boiling_[std::size_t(share.face)],
                    properties.temperature(field.enthalpy[node]),
                    !field.wetted.empty() && field.wetted[node] != 0);
}

bool SurfaceCooling::water_runs(Face face, const HeatStepInput& input) const {
  // Evaluated at the middle of the step, where the rounding of summed time steps does not matter.
  const double middle = input.time - 0.5 * input.time_step;
  return is_open(cooling_.water_of(face), middle) && water_flow_of(face, input) > 0.0;
}

void SurfaceCooling::mark_wetted(HeatField& field) const {
  if (!cooling_.water.boiling_follows_flow && !cooling_.water_of(Face::narrow).boiling_follows_flow)
    return;
  field.wetted.assign(flux_.size(), 0);
  for (std::size_t i = 0; i < side_.size(); ++i) {
    if (side_[i].law == law_water && film_share_[i] < 0.5)
      field.wetted[std::size_t(side_[i].node)] = 1;
  }
}

SurfaceFlux SurfaceCooling::side_flux(std::size_t share, const SurfaceState& surface,
                                      const HeatStepInput& input) const {
  const SidePlace place{input.time, side_[share].distance};
  const int law = side_[share].law;
  if (law == law_dry) return dry_flux(cooling_, surface);
  if (law == law_water) {
    const Face face = side_[share].face;
    return water_flux(cooling_.water_of(face), boiling_[std::size_t(face)], surface, place,
                      water_flow_of(face, input), film_share_[share]);
  }
  return zone_flux(cooling_.zones[std::size_t(law)], surface, place, cooling_.ambient_temperature);
}

void SurfaceCooling::add(int node, double weight, const SurfaceFlux& flux,
                         const ThermalState& state) {
  flux_[std::size_t(node)] += weight * flux.flux;
  flux_derivative_[std::size_t(node)] +=
      weight * (flux.d_temperature * state.temperature_derivative +
                flux.d_liquid_fraction * state.liquid_fraction_derivative);
}

void SurfaceCooling::add_side(std::span<const ThermalState> state, const HeatStepInput& input) {
  side_power_ = {};
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const ThermalState& at = state[std::size_t(side_[i].node)];
    const SurfaceFlux flux = side_flux(i, surface_of(at), input);
    add(side_[i].node, side_[i].weight, flux, at);
    side_power_[std::size_t(side_[i].face)] += side_[i].weight * flux.flux;
  }
}

void SurfaceCooling::add_bottom(const HeatForms& forms, std::span<const ThermalState> state,
                                const HeatStepInput& input) {
  bottom_power_ = 0.0;
  const std::vector<int>& nodes = forms.bottom_nodes();
  const std::vector<double>& weight = forms.bottom_weight();
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double gap = input.bottom_gap.empty() ? 0.0 : input.bottom_gap[i];
    const ThermalState& at = state[std::size_t(nodes[i])];
    const SurfaceFlux flux = bottom_flux(cooling_.bottom_block, surface_of(at), input.time, gap);
    add(nodes[i], weight[i], flux, at);
    bottom_power_ += weight[i] * flux.flux;
  }
}

void SurfaceCooling::evaluate(const HeatForms& forms, std::span<const ThermalState> state,
                              const HeatStepInput& input) {
  std::fill(flux_.begin(), flux_.end(), 0.0);
  std::fill(flux_derivative_.begin(), flux_derivative_.end(), 0.0);
  add_side(state, input);
  add_bottom(forms, state, input);
}

}  // namespace dccast::thermal
