#include "core/thermal/gap_water.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <queue>
#include <utility>

namespace dccast::thermal {
namespace {

constexpr double steam_density = 0.598;     // [kg/m3] saturated, at 1 bar
constexpr double steam_viscosity = 1.2e-5;  // [Pa s] the same

/// Darcy friction factor [1] between plates: laminar, or by Blasius.
double friction_factor(double reynolds) {
  return std::max(96.0 / reynolds, 0.316 * std::pow(reynolds, -0.25));
}

/// Water that meets at one place of the edge, by mass.
std::map<std::size_t, EdgeSupply> join(std::span<const EdgeSupply> supplies) {
  std::map<std::size_t, EdgeSupply> joined;
  for (const EdgeSupply& supply : supplies) {
    EdgeSupply& sum = joined.try_emplace(supply.edge, EdgeSupply{supply.edge, {}, 0.0}).first->second;
    const double before = sum.film.flow * sum.width, added = supply.film.flow * supply.width;
    if (added <= 0.0) continue;

    sum.film.temperature =
        (before * sum.film.temperature + added * supply.film.temperature) / (before + added);
    sum.width += supply.width;
    sum.film.flow = (before + added) / sum.width;
  }
  std::erase_if(joined, [](const auto& entry) { return entry.second.width <= 0.0; });
  return joined;
}

/// One stream, with the places it runs through from the edge inwards.
class GapStream {
public:
  GapStream(const GapWater& gap, const Water& law, const EdgeSupply& supply)
      : gap_(gap), law_(law), width_(supply.width) {
    // The streams cover a share of the width: there the water that gets in flows together.
    touched_width_ = gap.touching_share * supply.width;
    film_ = {supply.film.temperature,
             gap.inflow_share * supply.film.flow / gap.touching_share};
  }

  void add(std::size_t node, const GapSurface& at, double distance) {
    node_.push_back(node);
    place_.push_back({at.open * at.area, distance, at.gap});

    // The block's surface cools while it warms the water: 1 / (1 + compliance h) of the heat that
    // its temperature at the start would give.
    const double share = gap_.touching_share * at.open;
    const double wall = gap_.block_coefficient /
                        (1.0 + at.block.compliance * share * gap_.block_coefficient);
    piece_.push_back({.area = share * at.area,
                      .at = {0.0, law_.from + law_.wetting.jet_length + distance},
                      .surface_temperature = at.temperature,
                      .wetted = at.wetted,
                      .wall_coefficient = wall,
                      .wall_temperature = at.block.block});
  }

  void run(double instant, double time_step, std::span<const GapSurface> bottom,
           GapStreams& streams) {
    for (WetPiece& piece : piece_) piece.at.time = instant;
    std::vector<WaterPlace> water;
    const FilmEnd end = march_film(law_, film_, touched_width_, time_step, piece_, water);

    FaceWater& total = streams.water;
    total.capacity += film_capacity(film_, touched_width_);
    total.boiled_away = total.boiled_away || end.boiled_away;
    total.thrown_off = total.thrown_off || end.thrown_off;

    for (std::size_t i = 0; i < water.size(); ++i) {
      const GapSurface& at = bottom[node_[i]];
      const double share = gap_.touching_share * at.open;
      streams.place[node_[i]] = {share, water[i], share * water[i].wall_flux};
      total.taken += share * at.area * water[i].wall_flux;
      total.area += piece_[i].area;
      total.wetted += piece_[i].area * water[i].wetted;
    }
    add_steam(water, end, streams);
  }

private:
  void add_steam(std::span<const WaterPlace> water, const FilmEnd& end, GapStreams& streams) const {
    std::vector<double> steam;
    for (std::size_t i = 0; i < water.size(); ++i) {
      const double left = i + 1 < water.size() ? water[i + 1].film.flow : end.film.flow;
      steam.push_back(water_density * touched_width_ * (water[i].film.flow - left));
    }

    const std::vector<double> pressure = steam_pressure(place_, steam, width_);
    for (std::size_t i = 0; i < pressure.size(); ++i) {
      streams.steam_pressure = std::max(streams.steam_pressure, pressure[i]);
      streams.steam_force += pressure[i] * place_[i].area;
    }
  }

  const GapWater& gap_;
  const Water& law_;
  double width_;          ///< [m] of the edge
  double touched_width_;  ///< [m] of it that water covers
  Film film_;
  std::vector<std::size_t> node_;
  std::vector<GapPiece> place_;
  std::vector<WetPiece> piece_;
};

}  // namespace

std::vector<std::optional<GapRoute>> find_gap_routes(std::size_t nodes,
                                                     std::span<const BottomPath> paths,
                                                     std::span<const std::size_t> edge,
                                                     const std::vector<char>& open) {
  std::vector<std::vector<std::pair<std::size_t, double>>> neighbours(nodes);
  for (const BottomPath& path : paths) {
    neighbours[path.first].emplace_back(path.second, path.length);
    neighbours[path.second].emplace_back(path.first, path.length);
  }

  // Dijkstra's search from all open places of the edge at once; ties go to the lower number.
  using Arrival = std::pair<double, std::size_t>;
  std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> next;
  std::vector<std::optional<GapRoute>> route(nodes);
  for (const std::size_t n : edge) {
    if (open[n] == 0) continue;
    route[n] = GapRoute{n, 0.0};
    next.emplace(0.0, n);
  }

  while (!next.empty()) {
    const auto [distance, n] = next.top();
    next.pop();
    if (distance > route[n]->distance) continue;

    for (const auto& [neighbour, length] : neighbours[n]) {
      if (open[neighbour] == 0) continue;
      const double there = distance + length;
      if (route[neighbour] && route[neighbour]->distance <= there) continue;
      route[neighbour] = GapRoute{route[n]->edge, there};
      next.emplace(there, neighbour);
    }
  }
  return route;
}

std::vector<double> steam_pressure(std::span<const GapPiece> pieces, std::span<const double> steam,
                                   double width) {
  // Through a piece flows what it and all pieces behind it give off.
  std::vector<double> flow(steam.begin(), steam.end());  // [kg/s per metre of width]
  for (std::size_t i = flow.size(); i-- > 0;) {
    flow[i] /= width;
    if (i + 1 < flow.size()) flow[i] += flow[i + 1];
  }

  std::vector<double> pressure(pieces.size(), 0.0);
  double from = 0.0, sum = 0.0;  // [m] from the edge, [Pa]
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    if (i < flow.size() && flow[i] > 0.0) {
      const double velocity = flow[i] / (steam_density * pieces[i].gap);
      const double head = 0.5 * steam_density * velocity * velocity;
      const double reynolds = 2.0 * flow[i] / steam_viscosity;
      if (i == 0) sum = head;
      sum += friction_factor(reynolds) * head / (2.0 * pieces[i].gap) *
             (pieces[i].distance - from);
    }
    from = pieces[i].distance;
    pressure[i] = sum;
  }
  return pressure;
}

GapStreams lay_gap_water(const GapWater& gap, const Water& law,
                         std::span<const BottomPath> paths, std::span<const GapSurface> bottom,
                         std::span<const EdgeSupply> supplies, double instant, double time_step) {
  GapStreams streams;
  streams.place.resize(bottom.size());
  const auto supply = join(supplies);
  if (supply.empty()) return streams;

  std::vector<std::size_t> edge;
  for (const auto& [node, unused] : supply) edge.push_back(node);
  std::vector<char> open;
  for (const GapSurface& at : bottom) open.push_back(at.open > 0.0 ? 1 : 0);
  const auto route = find_gap_routes(bottom.size(), paths, edge, open);

  // Each stream meets its places in the order of their distance from the edge.
  std::vector<std::size_t> order;
  for (std::size_t n = 0; n < route.size(); ++n)
    if (route[n]) order.push_back(n);
  std::ranges::stable_sort(order, {}, [&](std::size_t n) { return route[n]->distance; });

  std::map<std::size_t, GapStream> by_edge;
  for (const std::size_t n : order) {
    const std::size_t from = route[n]->edge;
    by_edge.try_emplace(from, gap, law, supply.at(from))
        .first->second.add(n, bottom[n], route[n]->distance);
  }
  for (auto& [node, stream] : by_edge) stream.run(instant, time_step, bottom, streams);
  return streams;
}

}  // namespace dccast::thermal
