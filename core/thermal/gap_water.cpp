#include "core/thermal/gap_water.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <numbers>
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
    EdgeSupply& sum =
        joined.try_emplace(supply.edge, EdgeSupply{supply.edge, {}, 0.0}).first->second;
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
    film_ = {supply.film.temperature, gap.inflow_share * supply.film.flow / gap.touching_share};
  }

  void add(std::size_t node, const GapSurface& at, double distance) {
    node_.push_back(node);

    // The block's surface cools while it warms the water: 1 / (1 + compliance h) of the heat that
    // its temperature at the start would give.
    const double share = gap_.touching_share * at.open;
    const double wall =
        gap_.block_coefficient / (1.0 + at.block.compliance * share * gap_.block_coefficient);
    piece_.push_back({.area = share * at.area,
                      .at = {0.0, law_.from + law_.wetting.jet_length + distance},
                      .surface_temperature = at.temperature,
                      .wetted = at.wetted,
                      .wall_coefficient = wall,
                      .wall_temperature = at.block.block});
  }

  /// Lets the stream run over a hole behind the places so far, once.
  void drain(const GapHole& hole) {
    if (std::ranges::find(hole_, &hole) != hole_.end()) return;
    hole_.push_back(&hole);
    drain_.push_back({piece_.size(), std::min(1.0, hole.across / width_)});
  }

  /// @param steam  (bottom node) [kg/s] that water gives off; 2D per metre
  void run(double instant, double time_step, std::span<const GapSurface> bottom,
           GapStreams& streams, std::span<double> steam) {
    for (WetPiece& piece : piece_) piece.at.time = instant;
    streams.water.capacity += film_capacity(film_, touched_width_);

    // One march from hole to hole, and one from the last hole on.
    std::size_t first = 0;
    for (const Drain& drain : drain_) {
      if (!run_reach(first, drain.pieces, 1.0 - drain.share, time_step, bottom, streams, steam))
        return;
      first = drain.pieces;
    }
    run_reach(first, piece_.size(), 0.0, time_step, bottom, streams, steam);
  }

private:
  /// A hole that takes a share [1] of the water behind the first `pieces`.
  struct Drain {
    std::size_t pieces = 0;
    double share = 0.0;
  };

  /// @param onward  [1] share of the water that runs on at the end of the reach
  /// @return        whether any does
  bool run_reach(std::size_t first, std::size_t last, double onward, double time_step,
                 std::span<const GapSurface> bottom, GapStreams& streams, std::span<double> steam) {
    const std::span<const WetPiece> reach = std::span(piece_).subspan(first, last - first);
    std::vector<WaterPlace> water;
    const FilmEnd end = march_film(law_, film_, touched_width_, time_step, reach, water);

    film_ = {end.film.temperature, onward * end.film.flow};
    const bool runs_on =
        !end.boiled_away && !end.thrown_off && film_.flow >= law_.wetting.least_flow;
    if (runs_on && !water.empty()) reserve_heat(film_capacity(film_, touched_width_), reach, water);

    FaceWater& total = streams.water;
    total.boiled_away = total.boiled_away || end.boiled_away;
    total.thrown_off = total.thrown_off || end.thrown_off;
    for (std::size_t i = 0; i < water.size(); ++i) {
      const std::size_t node = node_[first + i];
      const GapSurface& at = bottom[node];
      const double share = gap_.touching_share * at.open;
      streams.place[node] = {share, water[i], share * water[i].wall_flux};
      total.taken += share * at.area * water[i].wall_flux;
      total.area += reach[i].area;
      total.wetted += reach[i].area * water[i].wetted;

      const double left = i + 1 < water.size() ? water[i + 1].film.flow : end.film.flow;
      steam[node] = water_density * touched_width_ * (water[i].film.flow - left);
    }
    return runs_on;
  }

  const GapWater& gap_;
  const Water& law_;
  double width_;          ///< [m] of the edge
  double touched_width_;  ///< [m] of it that water covers
  Film film_;             ///< at the edge, then behind the last hole that it has run over
  std::vector<std::size_t> node_;
  std::vector<WetPiece> piece_;
  std::vector<const GapHole*> hole_;  ///< that it runs over
  std::vector<Drain> drain_;          ///< (hole)
};

/// The places that have a route, from their openings inwards.
std::vector<std::size_t> sort_by_distance(std::span<const std::optional<GapRoute>> route) {
  std::vector<std::size_t> order;
  for (std::size_t n = 0; n < route.size(); ++n)
    if (route[n]) order.push_back(n);
  std::ranges::stable_sort(order, {}, [&](std::size_t n) { return route[n]->distance; });
  return order;
}

/// Adds the pressure of the steam that flows to one opening from all places nearest to it.
/// @param places  from the opening inwards @param steam  (bottom node) [kg/s]
void add_steam(std::span<const std::size_t> places, std::span<const std::optional<GapRoute>> route,
               const GapPassage& passage, std::span<const GapSurface> bottom,
               std::span<const double> steam, GapStreams& streams) {
  std::vector<GapPiece> pieces;
  std::vector<double> given_off;
  for (const std::size_t n : places) {
    const GapSurface& at = bottom[n];
    pieces.push_back({at.open * at.area, route[n]->distance, at.gap});
    given_off.push_back(steam[n]);
  }

  const std::vector<double> pressure = steam_pressure(pieces, given_off, passage);
  for (std::size_t i = 0; i < pressure.size(); ++i) {
    streams.steam_pressure = std::max(streams.steam_pressure, pressure[i]);
    streams.steam_force += pressure[i] * pieces[i].area;
  }
}

}  // namespace

std::vector<std::optional<GapRoute>> find_gap_routes(std::size_t nodes,
                                                     std::span<const BottomPath> paths,
                                                     std::span<const GapOpening> openings,
                                                     const std::vector<char>& open) {
  std::vector<std::vector<std::pair<std::size_t, double>>> neighbours(nodes);
  for (const BottomPath& path : paths) {
    neighbours[path.first].emplace_back(path.second, path.length);
    neighbours[path.second].emplace_back(path.first, path.length);
  }

  // Dijkstra's search from all openings at once; ties go to the lower number.
  using Arrival = std::pair<double, std::size_t>;
  std::priority_queue<Arrival, std::vector<Arrival>, std::greater<>> next;
  std::vector<std::optional<GapRoute>> route(nodes);
  for (const auto& [n, opening, distance] : openings) {
    if (open[n] == 0 || (route[n] && route[n]->distance <= distance)) continue;
    route[n] = GapRoute{opening, distance};
    next.emplace(distance, n);
  }

  while (!next.empty()) {
    const auto [distance, n] = next.top();
    next.pop();
    if (distance > route[n]->distance) continue;

    for (const auto& [neighbour, length] : neighbours[n]) {
      if (open[neighbour] == 0) continue;
      const double there = distance + length;
      if (route[neighbour] && route[neighbour]->distance <= there) continue;
      route[neighbour] = GapRoute{route[n]->opening, there};
      next.emplace(there, neighbour);
    }
  }
  return route;
}

double GapPassage::mean_width(double from, double to) const {
  const double narrow = width + spread * from, wide = width + spread * to;
  return narrow == wide ? narrow : (wide - narrow) / std::log(wide / narrow);
}

std::vector<double> steam_pressure(std::span<const GapPiece> pieces, std::span<const double> steam,
                                   const GapPassage& passage) {
  // Through a piece flows what it and all pieces behind it give off.
  std::vector<double> flow(steam.begin(), steam.end());  // [kg/s per metre of the opening]
  for (std::size_t i = flow.size(); i-- > 0;) {
    flow[i] /= passage.width;
    if (i + 1 < flow.size()) flow[i] += flow[i + 1];
  }

  const auto head_at = [](double flow_per_width, double gap) {
    const double velocity = flow_per_width / (steam_density * gap);
    return 0.5 * steam_density * velocity * velocity;
  };

  std::vector<double> pressure(pieces.size(), 0.0);
  double from = 0.0, sum = 0.0;  // [m] from the opening, [Pa]
  for (std::size_t i = 0; i < pieces.size(); ++i) {
    const GapPiece& piece = pieces[i];
    if (i < flow.size() && flow[i] > 0.0) {
      if (i == 0) sum = head_at(flow[i], piece.gap);

      const double there = flow[i] * (passage.width / passage.mean_width(from, piece.distance));
      const double reynolds = 2.0 * there / steam_viscosity;
      sum += friction_factor(reynolds) * head_at(there, piece.gap) / (2.0 * piece.gap) *
             (piece.distance - from);
    }
    from = piece.distance;
    pressure[i] = sum;
  }
  return pressure;
}

std::vector<GapHole> find_gap_holes(std::span<const DrainHole> holes,
                                    std::span<const std::array<double, 2>> places) {
  constexpr double round_off = 1e-9;  // [m]
  std::vector<GapHole> found;
  for (const DrainHole& hole : holes) {
    // A plane of symmetry leaves half of the hole in the quarter, both leave a quarter of it.
    const int planes = (hole.x < round_off ? 1 : 0) + (hole.y < round_off ? 1 : 0);
    const double radius = 0.5 * hole.diameter;
    const double angle = 2.0 * std::numbers::pi / (1 << planes);

    GapHole at{.nodes = {},
               .across = planes > 0 ? radius : hole.diameter,
               .passage = {angle * radius, angle}};
    GapHole::Node nearest{0, std::numeric_limits<double>::infinity()};
    for (std::size_t n = 0; n < places.size(); ++n) {
      const double from_rim = std::hypot(places[n][0] - hole.x, places[n][1] - hole.y) - radius;
      if (from_rim <= round_off) at.nodes.push_back({n, 0.0});
      if (from_rim < nearest.distance) nearest = {n, from_rim};
    }
    if (at.nodes.empty() && !places.empty()) at.nodes.push_back(nearest);
    found.push_back(at);
  }
  return found;
}

GapStreams lay_gap_water(const GapWater& gap, const Water& law, std::span<const BottomPath> paths,
                         std::span<const GapSurface> bottom, std::span<const EdgeSupply> supplies,
                         std::span<const GapHole> holes, double instant, double time_step) {
  GapStreams streams;
  streams.place.resize(bottom.size());
  const auto joined = join(supplies);
  if (joined.empty()) return streams;

  // The openings: the places of the edge, then the holes.
  std::vector<EdgeSupply> supply;
  std::vector<GapOpening> openings;
  std::vector<GapPassage> passage;
  for (const auto& [node, at] : joined) {
    openings.push_back({node, supply.size(), 0.0});
    passage.push_back({at.width});
    supply.push_back(at);
  }
  const std::size_t edges = openings.size();
  std::vector<std::vector<const GapHole*>> holes_at(bottom.size());
  for (const GapHole& hole : holes) {
    for (const auto& [node, distance] : hole.nodes) {
      openings.push_back({node, passage.size(), distance});
      holes_at[node].push_back(&hole);
    }
    passage.push_back(hole.passage);
  }

  // Water enters at the edge alone. Each stream meets its places in the order of their distance.
  std::vector<char> open;
  for (const GapSurface& at : bottom) open.push_back(at.open > 0.0 ? 1 : 0);
  auto route = find_gap_routes(bottom.size(), paths, std::span(openings).first(edges), open);
  std::map<std::size_t, GapStream> stream;
  for (const std::size_t n : sort_by_distance(route)) {
    const std::size_t from = route[n]->opening;
    GapStream& through = stream.try_emplace(from, gap, law, supply[from]).first->second;
    through.add(n, bottom[n], route[n]->distance);
    for (const GapHole* hole : holes_at[n]) through.drain(*hole);
  }

  std::vector<double> steam(bottom.size(), 0.0);  // [kg/s]
  for (auto& [number, each] : stream) each.run(instant, time_step, bottom, streams, steam);

  // Steam takes the way to the nearest opening.
  if (!holes.empty()) route = find_gap_routes(bottom.size(), paths, openings, open);
  std::vector<std::vector<std::size_t>> places(passage.size());
  for (const std::size_t n : sort_by_distance(route)) places[route[n]->opening].push_back(n);
  for (std::size_t i = 0; i < passage.size(); ++i)
    add_steam(places[i], route, passage[i], bottom, steam, streams);
  return streams;
}

}  // namespace dccast::thermal
