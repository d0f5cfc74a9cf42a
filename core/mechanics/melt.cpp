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
// What one sweep still moves, relative to the displacement or, while no node has moved, to what the
// first sweep moves: ten times less moves no node by a micrometre.
constexpr double follower_tolerance = 1e-7;
constexpr int most_follower_iterations = 1000;
constexpr double same_plane = 1.0 - 1e-9;  // [1] product of two unit normals

/// The matrix of the follower with some unknowns held at zero, K = L + D + L^T, and the halves of a
/// sweep of symmetric Gauss-Seidel. Vectors are zero where an unknown is held, before and after.
class FollowerMatrix {
public:
  FollowerMatrix(const linalg::SparsityPattern& pattern, std::span<const double> values,
                 std::span<const char> held)
      : start_(pattern.column_start()), row_(pattern.row()), values_(values), held_(held) {
    for (std::size_t i = 0; i < held.size(); ++i)
      if (held[i] == 0) free_.push_back(i);
  }

  const std::vector<std::size_t>& free() const { return free_; }
  double diagonal(std::size_t unknown) const { return values_[std::size_t(start_[unknown])]; }

  /// Scalar product over the free unknowns.
  double dot(std::span<const double> a, std::span<const double> b) const {
    double sum = 0.0;
    for (const std::size_t i : free_) sum += a[i] * b[i];
    return sum;
  }
  double norm(std::span<const double> v) const { return std::sqrt(dot(v, v)); }

  /// Replaces v by (L + D)^-1 v.
  void forwards(std::span<double> v) const {
    for (const std::size_t c : free_) {
      v[c] /= diagonal(c);
      below(c, [&](std::size_t row, double value) {
        if (held_[row] == 0) v[row] -= value * v[c];
      });
    }
  }

  /// Replaces v by (D + L^T)^-1 v.
  void backwards(std::span<double> v) const {
    for (auto at = free_.rbegin(); at != free_.rend(); ++at) {
      double sum = v[*at];
      below(*at, [&](std::size_t row, double value) { sum -= value * v[row]; });
      v[*at] = sum / diagonal(*at);
    }
  }

private:
  /// Calls visit(row, value) for the entries of a column below the diagonal.
  template <class Visit>
  void below(std::size_t column, const Visit& visit) const {
    for (int k = start_[column] + 1; k < start_[column + 1]; ++k)
      visit(std::size_t(row_[std::size_t(k)]), values_[std::size_t(k)]);
  }

  const std::vector<int>& start_;
  const std::vector<int>& row_;
  std::span<const double> values_;
  std::span<const char> held_;
  std::vector<std::size_t> free_;
};

/// Conjugate gradients with the preconditioner of symmetric Gauss-Seidel, one sweep an iteration
/// and no product with the matrix (Eisenstat): the unknowns are (D + L^T) x, so that residuals
/// are those of Gauss-Seidel, in metres.
/// @param v          residual: (L + D)^-1 b on entry; solution: x on return [m]
/// @param tolerance  [1] relative to the norm of that residual
linalg::CgOutcome solve_by_sweeps(const FollowerMatrix& matrix, linalg::GradientVectors<double>& v,
                                  double tolerance) {
  std::vector<double> turned(v.residual.size());
  const auto dot = [&](const auto& a, const auto& b) { return matrix.dot(a, b); };
  const auto precondition = [&] {
    for (const std::size_t i : matrix.free())
      v.preconditioned[i] = matrix.diagonal(i) * v.residual[i];
  };
  // (L + D)^-1 K t = t + (L + D)^-1 (p - D t), with t = (D + L^T)^-1 p.
  const auto multiply = [&] {
    std::ranges::copy(v.direction, turned.begin());
    matrix.backwards(turned);
    for (const std::size_t i : matrix.free())
      v.product[i] = v.direction[i] - matrix.diagonal(i) * turned[i];
    matrix.forwards(v.product);
    for (const std::size_t i : matrix.free()) v.product[i] += turned[i];
  };

  for (auto* vector : {&v.solution, &v.preconditioned, &v.direction, &v.product})
    vector->assign(v.residual.size(), 0.0);
  const auto outcome = linalg::iterate_gradients(v, matrix.norm(v.residual), precondition, multiply,
                                                 dot, {tolerance, most_follower_iterations});
  matrix.backwards(v.solution);
  return outcome;
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

  // From the present place of the free nodes: by how much one sweep would move them.
  const FollowerMatrix matrix(pattern, stiffness_, held);
  std::vector<double>& residual = gradients_.residual;
  residual.resize(displacement.size());
  linalg::multiply(pattern, stiffness_, displacement, residual);
  for (std::size_t i = 0; i < held.size(); ++i) residual[i] = held[i] != 0 ? 0.0 : -residual[i];
  matrix.forwards(residual);

  const double start = matrix.norm(residual);
  const double permitted = follower_tolerance * std::max(matrix.norm(displacement), start);
  if (start <= permitted) return;

  const auto outcome = solve_by_sweeps(matrix, gradients_, permitted / start);
  // What is left out of balance moves melt alone; more than before is no step towards its rest.
  if (!(outcome.residual < 1.0)) return;
  for (const std::size_t i : matrix.free()) displacement[i] += gradients_.solution[i];
}

template class Melt<2>;
template class Melt<3>;

}  // namespace dccast::mechanics
