#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// The supports of a slab: the symmetry planes, the mould along its sides, and the block below.
///
/// A side may be oblique to the coordinate axes. Its nodes then have local frames, so that their
/// displacement along the normal is one unknown. Sides that meet at less than 30 degrees are
/// treated there as one, with their mean normal; otherwise a shared node is held along both
/// normals.
///
/// The block pushes along the normal of its surface. Over the wall of a bowl that is oblique, too:
/// the third axis of the frame is then the normal, less what the node's other held directions take
/// of it.
template <int Dim>
class SlabSupports {
public:
  using Mesh = mesh::Mesh<Dim>;

  /// Finds the boundaries of a mesh. @pre the mesh is set in `forms`
  void find(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  /// Local frames of nodes whose normals are oblique to the coordinate axes.
  const std::vector<NodalFrame<Dim>>& frames() const { return frames_; }

  /// Nodes of the lower boundary, in ascending order of their numbers.
  const std::vector<int>& bottom_nodes() const { return bottom_nodes_; }
  /// (bottom node) tributary area [m^(Dim-1)], axisymmetric: [m2/rad].
  const std::vector<double>& bottom_area() const { return bottom_area_; }
  /// The same without the radius of an axisymmetric section [m^(Dim-1)].
  const std::vector<double>& bottom_measure() const { return bottom_measure_; }

  /// Whether the planes of symmetry leave the slab no rigid motion but the vertical one.
  bool stands_upright() const { return stands_upright_; }

  /// (bottom node) vertical part of the direction in which the block pushes [1]; 1 on a flat block.
  const std::vector<double>& upward() const { return upward_; }

  /// Sets the initial distance of the block below each bottom node [m]; empty: flat. It is kept as
  /// long as the number of bottom nodes does not change.
  /// @throws std::invalid_argument  not one number per bottom node
  void set_initial_gap(std::vector<double> gap);
  const std::vector<double>& initial_gap() const { return initial_gap_; }  ///< [m]
  /// (bottom node) whether the node initially stands on the block: all nodes on a flat block,
  /// otherwise those over its highest part.
  std::vector<char> initial_contact() const;

  /// Distance of the block below a bottom node [m]. @param place  index in bottom_nodes()
  /// @param displacement  by unknown [m]
  double bottom_gap(std::size_t place, std::span<const double> displacement) const;
  /// Whether a bottom node touches the block, or lies below it.
  bool is_on_block(std::size_t place, std::span<const double> displacement) const;

  /// Sets up contact of the body's nodes at the bottom or, without contact, holds them, and holds
  /// the planes of symmetry. @pre nothing is fixed in the problem
  /// @param of_body  (node) not zero: belongs to metal that carries load
  /// @return         places of its nodes in bottom_nodes(), in the order of the contact unknowns
  std::vector<std::size_t> place_on_block(StepProblem<Dim>& problem, bool contact,
                                          std::span<const char> of_body) const;
  /// Adds the support by the mould in this step, without memory of earlier ones. A node of the body
  /// is free where it is cold or below the mould, else it leans on the mould where it is: it cannot
  /// move outwards. A node of melt alone is held where it is.
  /// @param of_body       (node) not zero: belongs to metal that carries load
  /// @param temperature   (node) [°C]
  /// @param cold          [°C] below it the mould lets go of a node
  /// @param mould_bottom  [m] height of the lower edge of the mould
  /// @param displacement  by unknown [m]
  /// @param leaning       (unknown) not zero: leans at first
  /// @param closed        by contact unknown; on entry for the bottom, on return for the sides too
  void hold_sides(StepProblem<Dim>& problem, const Options& options, std::span<const char> of_body,
                  std::span<const double> temperature, double cold, double mould_bottom,
                  std::span<const double> displacement, std::span<const char> leaning,
                  std::vector<char>& closed) const;
  /// Marks the unknowns in which block, mould and symmetry planes hold melt.
  /// @param held  (unknown)
  void hold_melt(std::span<char> held) const;

  /// Displacements by unknown [m] from those along the coordinate axes [m].
  std::vector<double> by_unknown(std::vector<double> displacement) const;
  /// Displacements along the coordinate axes [m] from those by unknown [m].
  std::vector<double> by_coordinate(std::vector<double> displacement) const;
  /// Moves side nodes from number `first` on back to the mould. @param displacement  by unknown [m]
  void stand_at_mould(std::span<double> displacement, int first) const;

private:
  /// A direction along which the side holds a node.
  struct Direction {
    int unknown;
    double outward;  ///< [1] +1 if a positive increment moves the node towards the mould, else -1
    double area;     ///< tributary area on the side [m^(Dim-1)], axisymmetric: [m2/rad]
  };
  /// A node of the side, with one direction for each of its normals.
  struct SideNode {
    int node;
    double height;  ///< in the undeformed slab [m]
    std::vector<Direction> direction;
  };
  struct Normals;
  class HeldDirections;
  static constexpr int up = Dim - 1;

  /// Finds the nodes of the bottom, with their areas.
  void find_bottom(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  /// Finds the directions in which block, sides and symmetry planes hold their nodes.
  void find_directions(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  /// @param height  [m] in the undeformed slab
  void add_node(int node, double height, const Normals& normals);
  /// Adds a contact that closes at the present displacement [m].
  void lean(StepProblem<Dim>& problem, const Direction& direction, double displacement) const;

  std::vector<int> bottom_nodes_;
  std::vector<double> bottom_area_;     ///< (bottom node) @see bottom_area() [m^(Dim-1)], [m2/rad]
  std::vector<double> bottom_measure_;  ///< (bottom node) @see bottom_measure() [m^(Dim-1)]
  std::vector<double> upward_;          ///< (bottom node) @see upward() [1]
  std::vector<double> initial_gap_;     ///< (bottom node) [m]
  std::vector<SideNode> side_nodes_;
  std::vector<int> symmetry_unknowns_;
  bool stands_upright_ = false;  ///< @see stands_upright()
  std::vector<NodalFrame<Dim>> frames_;
};

}  // namespace dccast::mechanics
