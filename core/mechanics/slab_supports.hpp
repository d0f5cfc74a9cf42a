#pragma once

#include <span>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mechanics/slab_state.hpp"
#include "core/mechanics/step_problem.hpp"

namespace dccast::mechanics {

/// What holds a slab: the symmetry planes, the mould along its sides, and the block below.
///
/// A side may stand oblique to the coordinate axes. Its nodes then have frames, so that their
/// displacement along the normal is one unknown. Sides that meet at less than 30 degrees count as
/// one there, with their mean normal; others hold a node they share along both normals.
template <int Dim>
class SlabSupports {
public:
  using Mesh = mesh::Mesh<Dim>;

  /// Finds the boundaries of a mesh that the forms have taken.
  void find(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  const std::vector<NodalFrame<Dim>>& frames() const { return frames_; }

  const std::vector<int>& bottom_nodes() const { return bottom_nodes_; }
  /// Share of the bottom of each of its nodes [m^(Dim-1)], axisymmetric: [m2/rad].
  const std::vector<double>& bottom_area() const { return bottom_area_; }
  /// The same in the plane of the section [m^(Dim-1)], whether axisymmetric or not.
  const std::vector<double>& bottom_measure() const { return bottom_measure_; }

  /// How far the block lies below each bottom node before anything has moved [m]; empty: flat. It
  /// is kept while the bottom has as many nodes.
  /// @throws std::invalid_argument when there is not one number for each bottom node
  void set_initial_gap(std::vector<double> gap);
  const std::vector<double>& initial_gap() const { return initial_gap_; }  ///< [m]
  /// By bottom node, whether it stands on the block before anything has moved: all over a flat one,
  /// those over its highest part else.
  std::vector<char> initial_contact() const;

  /// Makes the bottom a contact or, without it, holds it. For a problem nothing of which is fixed.
  void place_on_block(StepProblem<Dim>& problem, bool contact) const;
  /// Releases the side where it is cold and says what the mould holds in this step.
  /// @param solidus        [°C] below which the mould lets go of a node for good
  /// @param mould_bottom   [m] height of the lower edge of the mould
  /// @param displacement   by unknown [m]
  /// @param closed         by contact unknown; of the bottom when called, then of the walls too
  void hold_sides(StepProblem<Dim>& problem, SlabState<Dim>& state, const Options& options,
                  std::span<const double> temperature, double solidus, double mould_bottom,
                  std::span<const double> displacement, std::vector<char>& closed) const;

  /// Displacements [m] by unknown, of displacements along the coordinate axes, and back.
  std::vector<double> by_unknown(std::vector<double> displacement) const;
  std::vector<double> by_coordinate(std::vector<double> displacement) const;
  /// Moves side nodes from `first` on back to the mould. @param displacement  by unknown
  /// [m]
  void stand_at_mould(std::span<double> displacement, int first) const;

private:
  /// A direction along which the side holds a node.
  struct Direction {
    int unknown;
    double outward;  ///< +1 where a growing unknown moves the node towards the mould, else -1
    double area;     ///< share of the side [m^(Dim-1)], axisymmetric: [m2/rad]
  };
  struct SideNode {
    int node;
    double height;  ///< of the undeformed slab [m]
    std::vector<Direction> direction;
  };
  struct Normals;
  class HeldDirections;
  static constexpr int up = Dim - 1;

  void find_bottom(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  void find_walls(const Mesh& mesh, const MechanicsForms<Dim>& forms);
  void add_node(int node, double height, const Normals& normals);
  void add_wall(StepProblem<Dim>& problem, const Direction& direction, double gap,
                bool was_released, std::vector<char>& closed) const;

  std::vector<int> bottom_nodes_;
  std::vector<double> bottom_area_;
  std::vector<double> bottom_measure_;
  std::vector<double> initial_gap_;
  std::vector<SideNode> side_nodes_;
  std::vector<int> symmetry_unknowns_;
  std::vector<NodalFrame<Dim>> frames_;
};

extern template class SlabSupports<2>;
extern template class SlabSupports<3>;

}  // namespace dccast::mechanics
