#include "core/thermal/surface_shares.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace dccast::thermal {
namespace {

using mesh::Mesh2D;
using mesh::SectionKind;

/// A facet as its two ends; xi runs from 0 at the first to 1 at the second.
struct Line {
  std::array<int, 2> node;
  std::array<double, 2> distance;  // [m] below the metal level
  std::array<double, 2> radius;    // [m]; 1 in plane strain
  double length;                   // [m]

  double distance_at(double xi) const { return distance[0] + xi * (distance[1] - distance[0]); }
  double radius_at(double xi) const { return radius[0] + xi * (radius[1] - radius[0]); }
};

Line line_of(const Mesh2D& mesh, const mesh::Facet<2>& facet, SectionKind kind, double level) {
  const double* a = mesh.point(facet.node[0]);
  const double* b = mesh.point(facet.node[1]);
  const bool round = kind == SectionKind::axisymmetric;
  return {{facet.node[0], facet.node[1]},
          {level - a[1], level - b[1]},
          {round ? a[0] : 1.0, round ? b[0] : 1.0},
          std::hypot(b[0] - a[0], b[1] - a[1])};
}

bool against_distance(const Curve& curve) {
  return !curve.empty() && !curve.constant() && curve.abscissa() == Abscissa::distance;
}

void add_kinks(const Curve& curve, std::vector<double>& edges) {
  if (against_distance(curve)) {
    edges.insert(edges.end(), curve.at().begin(), curve.at().end());
  }
}

/// Every distance below the metal level at which the law of the side may change or has a kink.
std::vector<double> side_edges(const CoolingSpec& cooling) {
  std::vector<double> edges{cooling.water.from};
  add_kinks(cooling.water.coefficient, edges);
  for (const SideZone& zone : cooling.zones) {
    edges.push_back(zone.from);
    edges.push_back(zone.to);
    add_kinks(zone.liquid_coefficient, edges);
    add_kinks(zone.solid_coefficient, edges);
  }
  std::sort(edges.begin(), edges.end());
  return edges;
}

int law_at(const CoolingSpec& cooling, double distance, bool water_runs) {
  if (water_runs && distance >= cooling.water.from) return law_water;
  for (std::size_t i = 0; i < cooling.zones.size(); ++i) {
    const SideZone& zone = cooling.zones[i];
    if (distance >= zone.from && distance < zone.to) return static_cast<int>(i);
  }
  return law_dry;
}

bool depends_on_distance(const CoolingSpec& cooling, int law) {
  if (law == law_dry) return false;
  if (law == law_water) return against_distance(cooling.water.coefficient);
  const SideZone& zone = cooling.zones[std::size_t(law)];
  return against_distance(zone.liquid_coefficient) || against_distance(zone.solid_coefficient);
}

/// Two Gauss points on [begin, end]: exact to the third power of xi, which is what a linear
/// coefficient, a shape function and a radius make together.
struct GaussPair {
  std::array<double, 2> xi;
  double weight;
};

GaussPair gauss_pair(double begin, double end) {
  const double half = 0.5 * (end - begin), middle = 0.5 * (begin + end);
  const double offset = half / std::sqrt(3.0);
  return {{middle - offset, middle + offset}, half};
}

void add_piece(const Line& line, double begin, double end, int law, bool by_distance,
               std::vector<SideShare>& shares) {
  const GaussPair gauss = gauss_pair(begin, end);
  for (std::size_t n = 0; n < 2; ++n) {
    double sum = 0.0;
    for (const double xi : gauss.xi) {
      const double weight =
          gauss.weight * line.length * (n == 0 ? 1.0 - xi : xi) * line.radius_at(xi);
      if (by_distance) shares.push_back({line.node[n], law, weight, line.distance_at(xi)});
      sum += weight;
    }
    if (!by_distance) {
      shares.push_back({line.node[n], law, sum, line.distance_at(0.5 * (begin + end))});
    }
  }
}

}  // namespace

void divide_side(const CoolingSpec& cooling, const Mesh2D& mesh, SectionKind kind,
                 double metal_level, bool water_runs, std::vector<SideShare>& shares) {
  shares.clear();
  const std::vector<double> edges = side_edges(cooling);
  for (const auto& facet : mesh.facets(mesh::PatchKind::side)) {
    const Line line = line_of(mesh, facet, kind, metal_level);
    const double rise = line.distance[1] - line.distance[0];
    const auto piece = [&](double begin, double end) {
      if (!(end > begin)) return;
      const int law = law_at(cooling, line.distance_at(0.5 * (begin + end)), water_runs);
      add_piece(line, begin, end, law, depends_on_distance(cooling, law), shares);
    };
    double begin = 0.0;
    const auto cut_at = [&](double edge) {
      const double xi = (edge - line.distance[0]) / rise;
      if (!(xi > begin && xi < 1.0)) return;
      piece(begin, xi);
      begin = xi;
    };
    if (rise > 0.0) {
      std::for_each(edges.begin(), edges.end(), cut_at);
    } else if (rise < 0.0) {
      std::for_each(edges.rbegin(), edges.rend(), cut_at);
    }
    piece(begin, 1.0);
  }
}

std::vector<double> bottom_weights(const Mesh2D& mesh, SectionKind kind,
                                   const std::vector<int>& bottom_nodes) {
  std::vector<double> by_node(std::size_t(mesh.nodes()), 0.0);
  std::vector<SideShare> shares;
  for (const auto& facet : mesh.facets(mesh::PatchKind::bottom)) {
    add_piece(line_of(mesh, facet, kind, 0.0), 0.0, 1.0, law_dry, false, shares);
  }
  for (const SideShare& share : shares) by_node[std::size_t(share.node)] += share.weight;
  std::vector<double> weights;
  weights.reserve(bottom_nodes.size());
  for (const int node : bottom_nodes) weights.push_back(by_node[std::size_t(node)]);
  return weights;
}

}  // namespace dccast::thermal
