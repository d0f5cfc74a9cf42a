#include "core/mechanics/melt.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dccast::mechanics {

namespace {

// Moduli of the elastic body that the melt is taken for to move its nodes [Pa]: of both only the
// ratio counts, and of that little (docs/developers/decisions.md).
constexpr double follower_shear = 1.0, follower_bulk = 1.0;
// Its forces out of balance, relative to those of each node alone or, while no node has moved, to
// those at the start: ten times less moves no node by a micrometre.
constexpr double follower_tolerance = 1e-7;
constexpr int most_follower_iterations = 1000;
constexpr double same_plane = 1.0 - 1e-9;  // [1] product of two unit normals

/// One sweep of symmetric Gauss-Seidel over the free unknowns, from zero, forwards and backwards.
/// Held ones stay at zero, or the sweep would not be symmetric.
void sweep(const linalg::SparsityPattern& pattern, std::span<const double> values,
           std::span<const char> held, std::span<const int> free, std::span<const double> r,
           std::span<double> z) {
  const auto& start = pattern.column_start();
  const auto& row = pattern.row();
  std::ranges::copy(r, z.begin());
  for (const int c : free) {
    const std::size_t first = std::size_t(start[std::size_t(c)]);
    const std::size_t end = std::size_t(start[std::size_t(c) + 1]);
    const double solved = z[std::size_t(c)] / values[first];
    for (std::size_t k = first + 1; k < end; ++k) z[std::size_t(row[k])] -= values[k] * solved;
  }

  for (std::size_t i = 0; i < held.size(); ++i)
    if (held[i] != 0) z[i] = 0.0;
  for (auto at = free.rbegin(); at != free.rend(); ++at) {
    const int c = *at;
    const std::size_t first = std::size_t(start[std::size_t(c)]);
    const std::size_t end = std::size_t(start[std::size_t(c) + 1]);
    double sum = z[std::size_t(c)];
    for (std::size_t k = first + 1; k < end; ++k) sum -= values[k] * z[std::size_t(row[k])];
    z[std::size_t(c)] = sum / values[first];
  }
}

}  // namespace

template <int Dim>
void Melt<Dim>::set_mesh(const Mesh& mesh, bool is_new) {
  mesh_ = &mesh;
  if (!is_new) return;
  inner_ = mesh::inner_facets(mesh);
  at_top_.assign(std::size_t(mesh.elements()), 0);
  mesh::for_each_facet(mesh, mesh::PatchKind::top, [&](const auto& facet, const auto&) {
    at_top_[std::size_t(facet.element)] = 1;
  });

  supported_by_.assign(std::size_t(mesh.elements()), 0);
  mesh::for_each_facet(mesh, mesh::PatchKind::bottom, [&](const auto& facet, const auto&) {
    supported_by_[std::size_t(facet.element)] |= 1U;
  });
  std::vector<std::array<double, Dim>> planes;
  mesh::for_each_facet(mesh, mesh::PatchKind::symmetry, [&](const auto& facet, const auto& patch) {
    auto plane = std::ranges::find_if(planes, [&](const auto& n) {
      return std::inner_product(n.begin(), n.end(), patch.normal.begin(), 0.0) > same_plane;
    });
    if (plane == planes.end()) plane = planes.insert(planes.end(), patch.normal);
    supported_by_[std::size_t(facet.element)] |= 2U << unsigned(plane - planes.begin());
  });
  all_supports_ = (2U << unsigned(planes.size())) - 1U;
}

template <int Dim>
std::vector<char> Melt<Dim>::carrying(std::span<const char> coherent) const {
  mesh::JoinedPieces pieces(mesh_->elements());
  for (const auto& [facet, beyond] : inner_) {
    if (coherent[std::size_t(facet.element)] != 0 && coherent[std::size_t(beyond)] != 0)
      pieces.join(facet.element, beyond);
  }

  std::vector<unsigned> supports(coherent.size(), 0);  // (first element of a piece)
  for (int e = 0; e < mesh_->elements(); ++e)
    supports[std::size_t(pieces.first_of(e))] |= supported_by_[std::size_t(e)];

  std::vector<char> carries(coherent.size(), 0);
  for (int e = 0; e < mesh_->elements(); ++e) {
    const bool supported = supports[std::size_t(pieces.first_of(e))] == all_supports_;
    carries[std::size_t(e)] = coherent[std::size_t(e)] != 0 && supported ? 1 : 0;
  }
  return carries;
}

template <int Dim>
double Melt<Dim>::press(const MechanicsForms<Dim>& forms, std::span<const char> carries,
                        double metal_level, double specific_weight, std::span<double> force) {
  mesh::JoinedPieces pools(mesh_->elements());
  for (const auto& [facet, beyond] : inner_) {
    if (carries[std::size_t(facet.element)] == 0 && carries[std::size_t(beyond)] == 0)
      pools.join(facet.element, beyond);
  }

  surface_.assign(carries.size(), -std::numeric_limits<double>::infinity());
  for (int e = 0; e < mesh_->elements(); ++e) {
    double& highest = surface_[std::size_t(pools.first_of(e))];
    for (int i = 0; i < mesh_->nodes_per_element; ++i)
      highest = std::max(highest, mesh_->point(mesh_->nodes_of(e)[i])[Dim - 1]);
  }
  for (int e = 0; e < mesh_->elements(); ++e) {
    if (at_top_[std::size_t(e)] != 0) surface_[std::size_t(pools.first_of(e))] = metal_level;
  }
  for (int e = 0; e < mesh_->elements(); ++e)
    surface_[std::size_t(e)] = surface_[std::size_t(pools.first_of(e))];

  double upward = 0.0;
  std::array<double, 4> pressure{};
  for (const auto& [facet, beyond] : inner_) {
    const bool inside = carries[std::size_t(facet.element)] != 0;
    if (inside == (carries[std::size_t(beyond)] != 0)) continue;

    // Where the metal lies beyond the facet, its outer side is the inner one of the facet.
    const double level = surface(inside ? beyond : facet.element);
    const double side = inside ? 1.0 : -1.0;
    for (std::size_t i = 0; i < std::size_t(facet.nodes); ++i) {
      const double depth = level - mesh_->point(facet.node[i])[Dim - 1];
      pressure[i] = side * specific_weight * std::max(0.0, depth);
    }
    upward += forms.add_pressure(facet, pressure, force);
  }
  return -upward;
}

template <int Dim>
void Melt<Dim>::assemble(const MechanicsForms<Dim>& forms, std::span<const char> carries,
                         const linalg::SparsityPattern& pattern) {
  stiffness_.assign(pattern.entries(), 0.0);
  const std::size_t places = elements_in_block * forms.points();
  std::vector<double> numbers(places * ResponseBlock<Dim>::numbers, 0.0);
  const ResponseBlock<Dim> response(numbers.data(), places);
  std::fill_n(response.shear, places, follower_shear);
  std::array<double, elements_in_block> bulk;
  bulk.fill(follower_bulk);

  for (std::size_t first = 0; first < forms.elements(); first += elements_in_block) {
    const ElementBlock block{first, std::min(first + elements_in_block, forms.elements())};
    const auto melt = carries.subspan(block.first, block.elements());
    if (std::ranges::find(melt, char{0}) == melt.end()) continue;
    forms.add_stiffness(block, response, bulk, pattern, stiffness_);
  }
}

template <int Dim>
void Melt<Dim>::follow(MechanicsForms<Dim>& forms, std::span<const char> carries,
                       const linalg::SparsityPattern& pattern, std::span<const char> held,
                       std::span<double> displacement) {
  std::vector<char> melt(carries.size());
  for (std::size_t e = 0; e < melt.size(); ++e) melt[e] = carries[e] == 0 ? 1 : 0;
  forms.set_taking_part(melt);
  assemble(forms, carries, pattern);
  forms.set_taking_part({});

  // From the present place of the free nodes: forces out of balance, beside those of each node
  // alone.
  std::vector<double> force(displacement.size());
  linalg::multiply(pattern, stiffness_, displacement, force);
  std::vector<int> free;
  double out_of_balance = 0.0, of_nodes = 0.0;
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] != 0) continue;
    free.push_back(static_cast<int>(i));
    force[i] = -force[i];
    const double alone =
        stiffness_[std::size_t(pattern.diagonal(static_cast<int>(i)))] * displacement[i];
    out_of_balance += force[i] * force[i];
    of_nodes += alone * alone;
  }
  const double permitted = follower_tolerance * std::sqrt(std::max(of_nodes, out_of_balance));
  if (std::sqrt(out_of_balance) <= permitted) return;

  std::vector<double> step(displacement.size(), 0.0);
  const auto precondition = [&](std::span<const double> r, std::span<double> z) {
    sweep(pattern, stiffness_, held, free, r, z);
  };
  const auto outcome =
      gradients_.solve(pattern, stiffness_, held, precondition, force, step,
                       {permitted / std::sqrt(out_of_balance), most_follower_iterations});
  // What is left out of balance moves melt alone; more than before is no step towards its rest.
  if (!(outcome.residual < 1.0)) return;
  for (const int i : free) displacement[std::size_t(i)] += step[std::size_t(i)];
}

template class Melt<2>;
template class Melt<3>;

}  // namespace dccast::mechanics
