#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

template <int Dim>
struct SlabState;

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

  /// Sets up contact at the bottom or, without contact, holds the bottom. @pre nothing is fixed in
  /// the problem
  void place_on_block(StepProblem<Dim>& problem, bool contact) const;
  /// Releases the side where it is cold, and adds the support by the mould in this step.
  /// @param temperature    (node) [°C]
  /// @param shell          [°C] below it the mould releases a node permanently
  /// @param mould_bottom   [m] height of the lower edge of the mould
  /// @param displacement   by unknown [m]
  /// @param closed         by contact unknown; on entry for the bottom, on return for the walls too
  void hold_sides(StepProblem<Dim>& problem, SlabState<Dim>& state, const Options& options,
                  std::span<const double> temperature, double shell, double mould_bottom,
                  std::span<const double> displacement, std::vector<char>& closed) const;

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
  /// @param gap  present gap to the wall [m]
  void add_wall(StepProblem<Dim>& problem, const Direction& direction, double gap,
                bool was_released, std::vector<char>& closed) const;

  std::vector<int> bottom_nodes_;
  std::vector<double> bottom_area_;     ///< (bottom node) @see bottom_area() [m^(Dim-1)], [m2/rad]
  std::vector<double> bottom_measure_;  ///< (bottom node) @see bottom_measure() [m^(Dim-1)]
  std::vector<double> upward_;          ///< (bottom node) @see upward() [1]
  std::vector<double> initial_gap_;     ///< (bottom node) [m]
  std::vector<SideNode> side_nodes_;
  std::vector<int> symmetry_unknowns_;
  std::vector<NodalFrame<Dim>> frames_;
};

}  // namespace dccast::mechanics
