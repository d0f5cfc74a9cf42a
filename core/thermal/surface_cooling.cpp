#include "core/thermal/surface_cooling.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "core/thermal/heat_forms.hpp"

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
  if (water.wiped_at) edges.push_back(*water.wiped_at);
  if (water.boiling_follows_flow) edges.push_back(water.from + water.wetting.jet_length);
  add_kinks(water.coefficient, edges);
}

using material::ThermalState;

/// Gaps up to this much wider than `wet_gap` are wet in part [1]; so the heat into the gap is a
/// continuous function of it.
constexpr double wet_gap_blend = 0.1;

double water_flow_of(Face face, const HeatStepInput& input) {
  return face == Face::narrow ? input.narrow_water_flow.value_or(input.water_flow)
                              : input.water_flow;
}

double mould_level_of(const HeatStepInput& input) {
  return input.mould_level.value_or(input.metal_level);
}

SurfaceState surface_of(const ThermalState& state) {
  return {state.temperature, state.liquid_fraction};
}

std::size_t face_index(const SideShare& share) {
  return faces * std::size_t(share.node) + std::size_t(share.face);
}

}  // namespace

SideLaws::SideLaws(const CoolingSpec& cooling, const SideInstant& instant)
    : cooling_(cooling),
      water_runs_(instant.water_runs),
      second_water_runs_(instant.second_water_runs),
      above_(instant.above) {
  add_water(cooling.water, edges_);
  if (const auto& second = cooling.second_water; second && second_water_runs_) {
    edges_.push_back(second->from);
    edges_.push_back(second->from + cooling.water.wetting.jet_length);
    if (cooling.narrow_water)
      edges_.push_back(second->from + cooling.narrow_water->wetting.jet_length);
  }
  if (cooling.narrow_water) add_water(*cooling.narrow_water, edges_);
  for (const SideZone& zone : cooling.zones) {
    edges_.push_back(upper_edge(zone));
    edges_.push_back(zone.to);
    add_kinks(zone.liquid_coefficient, edges_);
    add_kinks(zone.solid_coefficient, edges_);
  }

  std::sort(edges_.begin(), edges_.end());
}

LawAt SideLaws::at(double distance, Face face) const {
  // Water covers the zones of the mould.
  const Water& water = cooling_.water_of(face);
  const bool below = distance >= water.from;
  if (second_water_runs_ && distance >= cooling_.second_water->from) {
    const double wiped_at = water.wiped_at.value_or(HUGE_VAL);
    if (wiped_at <= cooling_.second_water->from || distance < wiped_at)
      return {law_water, against_distance(water.coefficient)};
  }
  if (water_runs_[std::size_t(face)] && below) {
    if (water.wiped_at && distance >= *water.wiped_at) return {law_dry, false};
    return {law_water, against_distance(water.coefficient)};
  }

  for (std::size_t i = 0; i < cooling_.zones.size(); ++i) {
    const SideZone& zone = cooling_.zones[i];
    if (distance < upper_edge(zone) || distance >= zone.to || zone.face.value_or(face) != face)
      continue;
    return {static_cast<int>(i),
            against_distance(zone.liquid_coefficient) || against_distance(zone.solid_coefficient)};
  }
  return {law_dry, false};
}

SurfaceCooling::SurfaceCooling(CoolingSpec cooling) : cooling_(std::move(cooling)) {
  if (cooling_.bottom_block.body) block_.emplace(*cooling_.bottom_block.body);

  gap_law_ = cooling_.water;
  if (const auto& gap = cooling_.bottom_block.gap_water)
    gap_law_.wetting.throw_off_length = gap->steam_reach;
}

void SurfaceCooling::resize(std::size_t nodes) {
  flux_.assign(nodes, 0.0);
  flux_derivative_.assign(nodes, 0.0);
}

void SurfaceCooling::begin_step(const HeatForms& forms,
                                const material::ThermalProperties& properties,
                                const HeatField& field, const HeatStepInput& input) {
  const double mould = mould_level_of(input);
  const double height = forms.divide_side(
      cooling_,
      {.mould_level = mould,
       .water_runs = {water_runs(Face::wide, input), water_runs(Face::narrow, input)},
       .rise = input.rise,
       .second_water_runs = second_water_runs(input),
       .above = std::max(0.0, input.metal_level - mould)},
      side_);

  lay_water(forms, properties, field, input, height);
  lay_bottom(forms, properties, field, input);
}

bool SurfaceCooling::water_runs(Face face, const HeatStepInput& input) const {
  // Evaluated at the middle of the step, where the rounding of summed time steps does not matter.
  const double middle = input.time - 0.5 * input.time_step;
  return is_open(cooling_.water_of(face), middle) && water_flow_of(face, input) > 0.0;
}

double SurfaceCooling::water_temperature(Face face, const HeatStepInput& input) const {
  const auto& given = input.water_temperature[std::size_t(face)];
  return given ? *given : cooling_.water_of(face).temperature(input.time);
}

/// Sorts the side shares by face and column, from the metal level down.
void SurfaceCooling::find_columns(const HeatForms& forms) {
  column_order_.resize(side_.size());
  std::iota(column_order_.begin(), column_order_.end(), std::size_t(0));
  const auto place = [&](std::size_t i) {
    const SideShare& share = side_[i];
    return std::tuple(share.face, forms.side_column()[std::size_t(share.node)], share.distance, i);
  };
  std::ranges::sort(column_order_, {}, place);
}

void SurfaceCooling::lay_water(const HeatForms& forms,
                               const material::ThermalProperties& properties,
                               const HeatField& field, const HeatStepInput& input,
                               double side_height) {
  water_ = {};
  side_water_.assign(side_.size(), {});
  edge_supply_.clear();
  if (std::ranges::none_of(side_, [](const auto& share) { return share.law == law_water; })) return;

  find_columns(forms);
  const auto column = [&](std::size_t i) {
    return std::pair(side_[i].face, forms.side_column()[std::size_t(side_[i].node)]);
  };

  // One stream of water for each column.
  for (auto first = column_order_.begin(); first != column_order_.end();) {
    const auto last = std::find_if(first, column_order_.end(),
                                   [&](std::size_t i) { return column(i) != column(*first); });

    // Water runs over its own shares; the width of the column follows from the area of all.
    double area = 0.0;
    for (auto share = first; share != last; ++share) area += side_[*share].weight;
    const bool wiped = side_[*(last - 1)].law != law_water;  // before it reaches the edge
    const auto wet = std::stable_partition(
        first, last, [this](std::size_t i) { return side_[i].law == law_water; });

    if (wet != first) {
      const double width = area / side_height;
      const FilmEnd end = lay_column({first, wet}, width, properties, field, input);
      if (!wiped && !end.boiled_away && !end.thrown_off)
        supply_edge(forms, column(*first).second, end.film, width);
    }
    first = last;
  }
}

/// The water of a column reaches the places of the edge below it; on a mesh without columns all of
/// the edge.
/// @param width  [m]; axisymmetric [m2/rad / m]
void SurfaceCooling::supply_edge(const HeatForms& forms, int column, const Film& film,
                                 double width) {
  if (!cooling_.bottom_block.gap_water) return;

  std::vector<std::size_t> below;
  for (std::size_t i = 0; i < forms.bottom_nodes().size(); ++i) {
    const std::size_t node = std::size_t(forms.bottom_nodes()[i]);
    if (forms.side_column()[node] == column) below.push_back(i);
  }
  for (const std::size_t i : below)
    edge_supply_.push_back({i, film, width / static_cast<double>(below.size())});
}

bool SurfaceCooling::second_water_runs(const HeatStepInput& input) const {
  return cooling_.second_water && input.second_water_flow > 0.0;
}

double SurfaceCooling::gap_share() const {
  const auto& gap = cooling_.bottom_block.gap_water;
  return gap ? gap->inflow_share : 0.0;
}

SurfaceCooling::Stretch SurfaceCooling::lay_stretch(std::span<const std::size_t> shares,
                                                    const Water& water, const Film& supply,
                                                    double width,
                                                    const material::ThermalProperties& properties,
                                                    const HeatField& field,
                                                    const HeatStepInput& input) {
  Stretch stretch;
  stretch.end.film = supply;
  for (const std::size_t i : shares) {
    const double wetted = field.wetted.empty() ? 0.0 : field.wetted[face_index(side_[i])];
    stretch.pieces.push_back({side_[i].weight,
                              {input.time, side_[i].distance},
                              properties.temperature(field.enthalpy[std::size_t(side_[i].node)]),
                              wetted});
    stretch.area += side_[i].weight;
  }
  if (shares.empty()) return stretch;

  // With fixed boiling properties the film does not change on its way.
  if (!water.boiling_follows_flow) {
    stretch.places.assign(
        shares.size(),
        {.film = supply, .critical_heat_flux = supply.critical_factor * water.critical_heat_flux});
    return stretch;
  }
  FaceWater& total = water_[std::size_t(side_[shares.front()].face)];
  stretch.end = march_film(water, supply, width, input.time_step, stretch.pieces, stretch.places);
  total.boiled_away = total.boiled_away || stretch.end.boiled_away;
  total.thrown_off = total.thrown_off || stretch.end.thrown_off;
  return stretch;
}

void SurfaceCooling::share_out(double width, Stretch& above, Stretch& below) const {
  if (above.places.empty() || below.places.empty()) return;
  const double left = film_capacity(above.end.film, width);
  const double left_below = (1.0 - gap_share()) * film_capacity(below.end.film, width);
  const double for_above = std::min(left, left_below) * above.area / (above.area + below.area);
  reserve_heat(left - for_above, above.pieces, above.places);
  reserve_heat(for_above, below.pieces, below.places);
}

void SurfaceCooling::keep(std::span<const std::size_t> shares, const Stretch& stretch) {
  for (std::size_t k = 0; k < shares.size(); ++k) {
    if (k >= stretch.places.size()) {
      side_[shares[k]].law = law_dry;
      continue;
    }
    FaceWater& total = water_[std::size_t(side_[shares[k]].face)];
    side_water_[shares[k]] = stretch.places[k];
    total.area += stretch.pieces[k].area;
    total.wetted += stretch.pieces[k].area * stretch.places[k].wetted;
  }
}

/// Runs water down the shares of one column. @param shares  one or more
/// @param width  [m]; axisymmetric [m2/rad / m]
FilmEnd SurfaceCooling::lay_column(std::span<const std::size_t> shares, double width,
                                   const material::ThermalProperties& properties,
                                   const HeatField& field, const HeatStepInput& input) {
  const Face face = side_[shares.front()].face;
  const Water& water = cooling_.water_of(face);
  const Film first{water_temperature(face, input), water_flow_of(face, input),
                   input.critical_heat_flux_factor[std::size_t(face)]};
  FaceWater& total = water_[std::size_t(face)];

  std::size_t count = shares.size();  // of the shares above the second water
  if (second_water_runs(input))
    count = std::size_t(std::ranges::partition_point(shares,
                                                     [&](std::size_t i) {
                                                       return side_[i].distance <
                                                              cooling_.second_water->from;
                                                     }) -
                        shares.begin());

  Stretch last = lay_stretch(shares.first(count), water, first, width, properties, field, input);
  if (count > 0) total.capacity += film_capacity(first, width);

  if (count < shares.size()) {
    // The films add where they meet, and the jets break a vapour film anew. What a wiper, steam or
    // boiling has taken away does not arrive.
    const double from = cooling_.second_water->from;
    const bool arrives = count > 0 && !last.end.boiled_away && !last.end.thrown_off &&
                         water.wiped_at.value_or(from + 1.0) > from;
    Film film{first.temperature, input.second_water_flow, first.critical_factor};
    total.capacity += film_capacity(film, width);
    if (arrives) film = joined(last.end.film, film);

    Water second = water;
    second.from = from;
    Stretch below =
        lay_stretch(shares.subspan(count), second, film, width, properties, field, input);
    if (arrives && water.boiling_follows_flow) share_out(width, last, below);
    keep(shares.first(count), last);
    last = std::move(below);
  } else {
    count = 0;
  }

  // What water that runs on into the gap could take is no longer the face's.
  if (cooling_.bottom_block.gap_water && water.boiling_follows_flow && !last.places.empty())
    reserve_heat(gap_share() * film_capacity(last.end.film, width), last.pieces, last.places);
  keep(shares.subspan(count), last);
  return last.end;
}

/// Whether water has met the butt on some face: it can then run into the gap, and stays there while
/// the valve of pulsed water is closed.
bool SurfaceCooling::water_at_butt(const HeatStepInput& input) const {
  for (const Face face : {Face::wide, Face::narrow}) {
    const Water& water = cooling_.water_of(face);
    if (water.enabled && input.time > water.start && water_flow_of(face, input) > 0.0 &&
        mould_level_of(input) > water.from)
      return true;
  }
  if (second_water_runs(input) && mould_level_of(input) > cooling_.second_water->from) return true;
  return false;
}

double SurfaceCooling::open_share(double gap) const {
  // Near the limiting width a gap is wet in part, so that the heat is continuous in its width.
  return std::clamp((gap / cooling_.bottom_block.wet_gap - 1.0) / wet_gap_blend, 0.0, 1.0);
}

void SurfaceCooling::lay_bottom(const HeatForms& forms,
                                const material::ThermalProperties& properties,
                                const HeatField& field, const HeatStepInput& input) {
  const BottomBlock& block = cooling_.bottom_block;
  bottom_.clear();
  if (forms.bottom_nodes().empty()) return;

  const bool wet = block.wet_coefficient && water_at_butt(input);
  const double start = block.temperature(input.time);
  const double water = wet || block_ ? water_temperature(Face::wide, input) : start;

  if (block_) block_->begin_step(input.time_step);

  const std::vector<double> cold(BlockColumns::points, start);
  for (std::size_t i = 0; i < forms.bottom_nodes().size(); ++i) {
    const double gap = input.bottom_gap.empty() ? 0.0 : input.bottom_gap[i];

    const double share = wet ? open_share(gap) : 0.0;
    BottomPlace place{.coefficient = (1.0 - share) * bottom_coefficient(block, input.time, gap),
                      .block = start,
                      .wet_coefficient = share * block.wet_coefficient.value_or(0.0),
                      .water = water};

    // With a body, the surface of the block responds to the flux by its compliance.
    if (block_) {
      std::span<const double> column = cold;
      if (!field.block_temperature.empty())
        column = std::span(field.block_temperature)
                     .subspan(i * BlockColumns::points, BlockColumns::points);
      place.block = block_->free_surface(column, water);
      place.compliance = block_->compliance();
    }

    bottom_.push_back(place);
  }

  if (block.gap_water) lay_gap(forms, properties, field, input);
}

/// Runs the water of the edge into the gap. What touches the slab replaces the way to the block.
void SurfaceCooling::lay_gap(const HeatForms& forms, const material::ThermalProperties& properties,
                             const HeatField& field, const HeatStepInput& input) {
  std::vector<GapSurface> surface;
  for (std::size_t i = 0; i < bottom_.size(); ++i) {
    const double gap = input.bottom_gap.empty() ? 0.0 : input.bottom_gap[i];
    const std::size_t node = std::size_t(forms.bottom_nodes()[i]);
    surface.push_back({.area = forms.bottom_weight()[i],
                       .gap = gap,
                       .open = open_share(gap),
                       .temperature = properties.temperature(field.enthalpy[node]),
                       .wetted = field.gap_wetted.empty() ? 0.0 : field.gap_wetted[i],
                       .block = bottom_[i]});
  }

  const auto holes = find_gap_holes(cooling_.bottom_block.drain_holes, forms.bottom_places());
  gap_streams_ = lay_gap_water(*cooling_.bottom_block.gap_water, gap_law_, forms.bottom_paths(),
                               surface, edge_supply_, holes, input.time, input.time_step);

  // The heat from block to water is fixed for the step: it lowers the block's own temperature.
  for (std::size_t i = 0; i < bottom_.size(); ++i) {
    const GapPlace& water = gap_streams_.place[i];
    bottom_[i].coefficient *= 1.0 - water.share;
    bottom_[i].block -= bottom_[i].compliance * water.block_flux;
  }
  gap_from_block_ = gap_streams_.water.taken;
}

/// Heat between slab, block and water at one place of the bottom, at a state of the slab's surface.
BottomFlux SurfaceCooling::flux_at_bottom(std::size_t place, const SurfaceState& surface) const {
  BottomFlux flux = bottom_flux(cooling_.bottom_block, bottom_[place], surface);
  if (!cooling_.bottom_block.gap_water) return flux;

  const SurfaceFlux into_water = flux_into_gap(place, surface);
  flux.slab.flux += into_water.flux;
  flux.slab.d_temperature += into_water.d_temperature;
  flux.into_block -= gap_streams_.place[place].block_flux;
  return flux;
}

SurfaceFlux SurfaceCooling::flux_into_gap(std::size_t place, const SurfaceState& surface) const {
  const GapPlace& gap = gap_streams_.place[place];
  if (gap.share <= 0.0) return {};
  const SurfaceFlux flux = water_flux(gap_law_, gap.water, surface, {});
  return {gap.share * flux.flux, gap.share * flux.d_temperature, 0.0};
}

SurfaceFlux SurfaceCooling::side_flux(std::size_t share, const SurfaceState& surface,
                                      const HeatStepInput& input) const {
  SidePlace place{input.time, side_[share].distance};
  if (!input.inward.empty()) place.inward = input.inward[face_index(side_[share])];
  const int law = side_[share].law;
  if (law == law_dry) return dry_flux(cooling_, surface);
  if (law == law_water)
    return water_flux(cooling_.water_of(side_[share].face), side_water_[share], surface, place);
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
  for (FaceWater& water : water_) water.taken = 0.0;
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const ThermalState& surface = state[std::size_t(side_[i].node)];
    const SurfaceFlux flux = side_flux(i, surface_of(surface), input);
    add(side_[i].node, side_[i].weight, flux, surface);

    const double power = side_[i].weight * flux.flux;
    side_power_[std::size_t(side_[i].face)] += power;
    if (side_[i].law == law_water) water_[std::size_t(side_[i].face)].taken += power;
  }
}

/// Adds the fluxes at the nodes of the bottom or of the level. @return their power [W/m]
template <class FluxAt>
double SurfaceCooling::add_patch(const std::vector<int>& nodes, const std::vector<double>& weight,
                                 std::span<const ThermalState> state, const FluxAt& flux_at) {
  double power = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const ThermalState& surface = state[std::size_t(nodes[i])];
    const SurfaceFlux flux = flux_at(i, surface_of(surface));
    add(nodes[i], weight[i], flux, surface);
    power += weight[i] * flux.flux;
  }
  return power;
}

void SurfaceCooling::evaluate(const HeatForms& forms, std::span<const ThermalState> state,
                              const HeatStepInput& input) {
  std::fill(flux_.begin(), flux_.end(), 0.0);
  std::fill(flux_derivative_.begin(), flux_derivative_.end(), 0.0);

  add_side(state, input);

  bottom_power_ = add_patch(
      forms.bottom_nodes(), forms.bottom_weight(), state,
      [&](std::size_t i, const SurfaceState& surface) { return flux_at_bottom(i, surface).slab; });
  if (cooling_.bottom_block.gap_water) {
    gap_streams_.water.taken = gap_from_block_;
    for (std::size_t i = 0; i < bottom_.size(); ++i) {
      const SurfaceState surface = surface_of(state[std::size_t(forms.bottom_nodes()[i])]);
      gap_streams_.water.taken += forms.bottom_weight()[i] * flux_into_gap(i, surface).flux;
    }
  }

  // A level that is held at the casting temperature loses no heat of its own.
  level_power_ = 0.0;
  if (cooling_.top == Top::pouring && cooling_.level_coefficient != 0.0)
    level_power_ = add_patch(
        forms.top_nodes(), forms.top_weight(), state,
        [&](std::size_t, const SurfaceState& surface) { return level_flux(cooling_, surface); });
}

/// Stores the wetted share of each side node. A surface that water has left dries with the same lag
/// as it is wetted.
void SurfaceCooling::store_wetted(std::span<const ThermalState> state, const HeatStepInput& input,
                                  HeatField& field) const {
  if (!cooling_.water.boiling_follows_flow && !cooling_.water_of(Face::narrow).boiling_follows_flow)
    return;

  const std::size_t size = faces * state.size();
  field.wetted.resize(size, 0.0);
  std::vector<double> wet(size, 0.0), area(size, 0.0);

  // Mean over the shares of a node, weighted by their areas.
  for (std::size_t i = 0; i < side_.size(); ++i) {
    const Water& water = cooling_.water_of(side_[i].face);
    if (side_[i].law != law_water || !water.boiling_follows_flow) continue;
    const double surface = state[std::size_t(side_[i].node)].temperature;
    wet[face_index(side_[i])] +=
        side_[i].weight * wet_in_the_end(water.wetting, surface, side_water_[i].rewetting);
    area[face_index(side_[i])] += side_[i].weight;
  }

  for (std::size_t i = 0; i < size; ++i) {
    const Water& water = cooling_.water_of(Face(i % faces));
    if (!water.boiling_follows_flow) continue;
    field.wetted[i] = wetted_after(water.wetting, field.wetted[i],
                                   area[i] > 0.0 ? wet[i] / area[i] : 0.0, input.time_step);
  }
}

/// The same at the bottom, which dries with the same lag.
void SurfaceCooling::store_gap_wetted(const HeatForms& forms, std::span<const ThermalState> state,
                                      const HeatStepInput& input, HeatField& field) const {
  field.gap_wetted.resize(bottom_.size(), 0.0);
  for (std::size_t i = 0; i < bottom_.size(); ++i) {
    const GapPlace& gap = gap_streams_.place[i];
    const double surface = state[std::size_t(forms.bottom_nodes()[i])].temperature;
    const double end =
        gap.share > 0.0 ? wet_in_the_end(gap_law_.wetting, surface, gap.water.rewetting) : 0.0;
    field.gap_wetted[i] = wetted_after(gap_law_.wetting, field.gap_wetted[i], end, input.time_step);
  }
}

void SurfaceCooling::finish_step(const HeatForms& forms, std::span<const ThermalState> state,
                                 const HeatStepInput& input, HeatField& field) const {
  store_wetted(state, input, field);
  if (cooling_.bottom_block.gap_water) store_gap_wetted(forms, state, input, field);
  if (!block_) return;

  const std::vector<int>& nodes = forms.bottom_nodes();
  if (field.block_temperature.empty())
    field.block_temperature.assign(nodes.size() * BlockColumns::points,
                                   cooling_.bottom_block.temperature(input.time - input.time_step));

  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const SurfaceState surface = surface_of(state[std::size_t(nodes[i])]);
    block_->finish(
        flux_at_bottom(i, surface).into_block, bottom_[i].water,
        std::span(field.block_temperature).subspan(i * BlockColumns::points, BlockColumns::points));
  }
}

}  // namespace dccast::thermal
