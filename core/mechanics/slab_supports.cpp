#include "core/mechanics/slab_supports.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>

#include "core/mesh/bottom_normals.hpp"

namespace dccast::mechanics {

namespace {

// Normals at less than 30 degrees belong to one smooth side.
const double same_side = std::cos(30.0 / 180.0 * 3.14159265358979323846);
constexpr double along_axis = 1.0 - 1e-12;  // component of a unit vector along an axis
constexpr double no_direction = 1e-6;       // [1] length of the remainder of a unit vector
constexpr double touching = 1e-9;           // gap of a node that stands at block or wall [m]
constexpr double round_off_of_turns = 16.0 * std::numeric_limits<double>::epsilon();

template <int Dim, class Turn>
std::vector<double> turned(const std::vector<NodalFrame<Dim>>& frames, std::vector<double> v,
                           Turn&& turn) {
  for (const auto& frame : frames) {
    double* components = &v[std::size_t(frame.node) * Dim];
    typename NodalFrame<Dim>::Vector vector;
    std::copy_n(components, Dim, vector.begin());
    vector = turn(frame, vector);
    std::copy(vector.begin(), vector.end(), components);
  }
  return v;
}

}  // namespace

/// The faces that bound the slab at a node, as unit normals [1]: horizontal ones of symmetry planes
/// and sides, and the inward one of a block that is not flat there.
template <int Dim>
struct SlabSupports<Dim>::Normals {
  using Vector = Eigen::Matrix<double, Dim, 1>;
  struct Side {
    Vector sum;  ///< of the normals that count as one
    double area;
  };
  std::vector<Vector> symmetry;
  std::vector<Side> sides;
  Vector block = Vector::Unit(up);

  void add_side(const Vector& normal, double area) {
    for (Side& side : sides) {
      if (normal.dot(side.sum.normalized()) < same_side) continue;
      side.sum += area * normal;
      side.area += area;
      return;
    }
    sides.push_back({area * normal, area});
  }
};

template <int Dim>
void SlabSupports<Dim>::find(const Mesh& mesh, const MechanicsForms<Dim>& forms) {
  find_bottom(mesh, forms);
  find_directions(mesh, forms);
}

template <int Dim>
void SlabSupports<Dim>::find_bottom(const Mesh& mesh, const MechanicsForms<Dim>& forms) {
  bottom_nodes_ = mesh::patch_nodes(mesh, mesh::PatchKind::bottom);
  std::vector<int> place(std::size_t(mesh.nodes()), -1);
  for (std::size_t i = 0; i < bottom_nodes_.size(); ++i) {
    place[std::size_t(bottom_nodes_[i])] = static_cast<int>(i);
  }
  bottom_area_.assign(bottom_nodes_.size(), 0.0);
  bottom_measure_ = bottom_area_;
  mesh::for_each_facet(mesh, mesh::PatchKind::bottom, [&](const auto& facet, const auto&) {
    const auto area = forms.facet_shares(facet), plain = fem::facet_shares(mesh, facet);
    for (std::size_t k = 0; k < std::size_t(facet.nodes); ++k) {
      const std::size_t i = std::size_t(place[std::size_t(facet.node[k])]);
      bottom_area_[i] += area[k];
      bottom_measure_[i] += plain[k];
    }
  });
  if (initial_gap_.size() != bottom_nodes_.size()) initial_gap_.clear();
}

template <int Dim>
void SlabSupports<Dim>::find_directions(const Mesh& mesh, const MechanicsForms<Dim>& forms) {
  std::map<int, Normals> node_normals;
  const auto block_normals = mesh::inward_normals(mesh, bottom_nodes_);
  for (std::size_t i = 0; i < block_normals.size(); ++i) {
    if (block_normals[i][up] >= along_axis) continue;
    node_normals[bottom_nodes_[i]].block = typename Normals::Vector(block_normals[i].data());
  }

  const auto horizontal = [](const std::array<double, Dim>& normal) {
    typename Normals::Vector n(normal.data());
    n(up) = 0.0;
    return n.norm() > no_direction ? std::optional(n.normalized()) : std::nullopt;
  };
  std::optional<typename Normals::Vector> first_plane;
  stands_upright_ = false;
  mesh::for_each_facet(mesh, mesh::PatchKind::symmetry, [&](const auto& facet, const auto& patch) {
    const auto normal = horizontal(patch.normal);
    if (normal) {
      if (!first_plane) first_plane = normal;
      // A section needs one plane, a solid two that meet.
      if (Dim == 2 || std::abs(normal->dot(*first_plane)) < along_axis) stands_upright_ = true;
    }
    for (int k = 0; normal && k < facet.nodes; ++k) {
      node_normals[facet.node[std::size_t(k)]].symmetry.push_back(*normal);
    }
  });
  mesh::for_each_facet(mesh, mesh::PatchKind::side, [&](const auto& facet, const auto& patch) {
    const auto normal = horizontal(patch.normal);
    const auto area = forms.facet_shares(facet);
    for (std::size_t k = 0; normal && k < std::size_t(facet.nodes); ++k) {
      node_normals[facet.node[k]].add_side(*normal, area[k]);
    }
  });

  side_nodes_.clear();
  symmetry_unknowns_.clear();
  frames_.clear();
  for (const auto& [node, normals] : node_normals) add_node(node, mesh.point(node)[up], normals);

  upward_.assign(bottom_nodes_.size(), 1.0);
  for (std::size_t i = 0; i < bottom_nodes_.size(); ++i) {
    if (block_normals[i][up] >= along_axis) continue;
    const auto frame = std::ranges::find(frames_, bottom_nodes_[i], &NodalFrame<Dim>::node);
    if (frame != frames_.end()) upward_[i] = frame->axis[up][up];
  }
}

/// Orthogonal directions along which a node is held: first the symmetry planes, then the remaining
/// components of the side normals, and that of the block.
template <int Dim>
class SlabSupports<Dim>::HeldDirections {
public:
  using Vector = typename Normals::Vector;

  explicit HeldDirections(const Normals& normals) {
    for (const Vector& normal : normals.symmetry) add(normal);
    of_symmetry = direction.size();
    for (const auto& side : normals.sides) {
      if (add(side.sum.normalized())) area.push_back(side.area);
    }
    block_ = normals.block;
    for (const Vector& d : direction) block_ -= d.dot(block_) * d;
    block_.normalize();
  }

  /// Whether all directions are coordinate axes.
  bool along_axes() const {
    return block_(up) >= along_axis && std::ranges::all_of(direction, [](const Vector& d) {
             return d.cwiseAbs().maxCoeff() >= along_axis;
           });
  }
  /// Frame of these directions, completed by the remaining ones; its last axis is that of the
  /// block.
  NodalFrame<Dim> frame(int node) const {
    std::vector<Vector> axis = direction;
    if constexpr (Dim == 3) {
      // A tangent of the block; where nothing else is held, the one across its slope.
      if (axis.empty()) axis.push_back(Vector::UnitZ().cross(block_).normalized());
      if (axis.size() == 1) axis.push_back(block_.cross(axis[0]));
    } else {
      if (axis.empty()) axis.push_back({block_(1), -block_(0)});
    }
    axis.push_back(block_);

    NodalFrame<Dim> frame{node, {}};
    for (std::size_t k = 0; k < axis.size(); ++k)
      std::copy(axis[k].begin(), axis[k].end(), frame.axis[k].begin());
    return frame;
  }

  std::vector<Vector> direction;
  std::size_t of_symmetry = 0;
  std::vector<double> area;  ///< of those of the side

private:
  bool add(Vector normal) {
    for (const Vector& d : direction) normal -= d.dot(normal) * d;
    if (normal.norm() <= no_direction) return false;
    direction.push_back(normal.normalized());
    return true;
  }

  Vector block_;  ///< what the held directions leave of the block's normal
};

template <int Dim>
void SlabSupports<Dim>::add_node(int node, double height, const Normals& normals) {
  const HeldDirections held(normals);
  const bool framed = !held.along_axes();
  if (framed) frames_.push_back(held.frame(node));

  SideNode side{node, height, {}};
  for (std::size_t k = 0; k < held.direction.size(); ++k) {
    Eigen::Index axis = static_cast<Eigen::Index>(k);
    double outward = 1.0;
    if (!framed) {
      held.direction[k].cwiseAbs().maxCoeff(&axis);
      outward = held.direction[k](axis) > 0.0 ? 1.0 : -1.0;
    }

    const int unknown = node * Dim + static_cast<int>(axis);
    if (k < held.of_symmetry)
      symmetry_unknowns_.push_back(unknown);
    else
      side.direction.push_back({unknown, outward, held.area[k - held.of_symmetry]});
  }
  if (!normals.sides.empty()) side_nodes_.push_back(std::move(side));
}

template <int Dim>
void SlabSupports<Dim>::set_initial_gap(std::vector<double> gap) {
  if (!gap.empty() && gap.size() != bottom_nodes_.size()) {
    throw std::invalid_argument("initial gap of the bottom: " + std::to_string(gap.size()) +
                                " numbers for " + std::to_string(bottom_nodes_.size()) + " nodes");
  }
  initial_gap_ = std::move(gap);
}

template <int Dim>
std::vector<char> SlabSupports<Dim>::initial_contact() const {
  std::vector<char> closed(bottom_nodes_.size(), 1);
  if (initial_gap_.empty()) return closed;
  const double least = *std::ranges::min_element(initial_gap_);
  for (std::size_t i = 0; i < closed.size(); ++i) {
    closed[i] = initial_gap_[i] <= least + touching ? 1 : 0;
  }
  return closed;
}

template <int Dim>
double SlabSupports<Dim>::bottom_gap(std::size_t place,
                                     std::span<const double> displacement) const {
  const std::size_t unknown = std::size_t(bottom_nodes_[place] * Dim + up);
  return displacement[unknown] + (initial_gap_.empty() ? 0.0 : initial_gap_[place]);
}

template <int Dim>
bool SlabSupports<Dim>::is_on_block(std::size_t place, std::span<const double> displacement) const {
  return bottom_gap(place, displacement) <= touching;
}

template <int Dim>
std::vector<std::size_t> SlabSupports<Dim>::place_on_block(StepProblem<Dim>& problem, bool contact,
                                                           std::span<const char> of_body) const {
  problem.contact.clear();
  problem.contact_area.clear();
  problem.initial_gap.clear();
  problem.contact_sense.clear();
  problem.walls = 0;

  std::vector<std::size_t> standing;
  for (std::size_t i = 0; i < bottom_nodes_.size(); ++i) {
    if (of_body[std::size_t(bottom_nodes_[i])] == 0) continue;
    standing.push_back(i);
    const int unknown = bottom_nodes_[i] * Dim + up;
    if (!contact) {
      problem.fixed[std::size_t(unknown)] = 1;
      continue;
    }
    problem.contact.push_back(unknown);
    problem.contact_area.push_back(bottom_area_[i]);
    if (!initial_gap_.empty()) problem.initial_gap.push_back(initial_gap_[i]);
  }
  for (int unknown : symmetry_unknowns_) problem.fixed[std::size_t(unknown)] = 1;
  return standing;
}

template <int Dim>
void SlabSupports<Dim>::hold_sides(StepProblem<Dim>& problem, const Options& options,
                                   std::span<const char> of_body,
                                   std::span<const double> temperature, double cold,
                                   double mould_bottom, std::span<const double> displacement,
                                   std::span<const char> leaning, std::vector<char>& closed) const {
  const bool exact = options.confinement_by == Confinement::exact;
  problem.spring.assign(exact ? 0 : problem.unknowns(), 0.0);
  if (!options.confinement) return;

  for (const SideNode& side : side_nodes_) {
    const std::size_t node = std::size_t(side.node);
    const bool is_free = temperature[node] < cold || side.height < mould_bottom;
    if (of_body[node] != 0 && is_free) continue;

    for (const Direction& d : side.direction) {
      const std::size_t unknown = std::size_t(d.unknown);
      problem.target[unknown] = displacement[unknown];
      if (!exact) {
        problem.spring[unknown] = options.confinement_stiffness * d.area;
      } else if (of_body[node] != 0) {
        lean(problem, d, displacement[unknown]);
        closed.push_back(leaning[unknown]);
      } else {
        problem.fixed[unknown] = 1;
      }
    }
  }
}

template <int Dim>
void SlabSupports<Dim>::lean(StepProblem<Dim>& problem, const Direction& direction,
                             double displacement) const {
  if (problem.contact_sense.empty()) problem.contact_sense.assign(problem.contact.size(), 1.0);
  if (problem.initial_gap.empty()) problem.initial_gap.assign(problem.contact.size(), 0.0);
  problem.contact.push_back(direction.unknown);
  problem.contact_sense.push_back(-direction.outward);
  problem.contact_area.push_back(direction.area);
  problem.initial_gap.push_back(direction.outward * displacement);
  ++problem.walls;
}

template <int Dim>
void SlabSupports<Dim>::hold_melt(std::span<char> held) const {
  for (const int unknown : symmetry_unknowns_) held[std::size_t(unknown)] = 1;
  for (const int node : bottom_nodes_) held[std::size_t(node * Dim + up)] = 1;
  for (const SideNode& side : side_nodes_)
    for (const Direction& d : side.direction) held[std::size_t(d.unknown)] = 1;
}

/// A displacement held in a local frame is zero up to the round-off of two rotations. It is reset
/// to zero; otherwise a step would begin by moving held unknowns.
template <int Dim>
std::vector<double> SlabSupports<Dim>::by_unknown(std::vector<double> displacement) const {
  return turned<Dim>(frames_, std::move(displacement), [](const auto& frame, const auto& v) {
    auto along = frame.to_frame(v);
    double size = 0.0;
    for (const double a : along) size = std::max(size, std::abs(a));
    for (double& a : along) {
      if (std::abs(a) <= round_off_of_turns * size) a = 0.0;
    }
    return along;
  });
}

template <int Dim>
std::vector<double> SlabSupports<Dim>::by_coordinate(std::vector<double> displacement) const {
  return turned<Dim>(frames_, std::move(displacement),
                     [](const auto& frame, const auto& v) { return frame.to_coordinates(v); });
}

template <int Dim>
void SlabSupports<Dim>::stand_at_mould(std::span<double> displacement, int first) const {
  for (const SideNode& side : side_nodes_) {
    if (side.node < first) continue;
    for (const Direction& d : side.direction) displacement[std::size_t(d.unknown)] = 0.0;
  }
}

template class SlabSupports<2>;
template class SlabSupports<3>;

}  // namespace dccast::mechanics
