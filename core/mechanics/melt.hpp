#pragma once

#include <array>
#include <span>
#include <vector>

#include "core/linalg/conjugate_gradients.hpp"
#include "core/mechanics/mechanics_forms.hpp"
#include "core/mesh/inner_facets.hpp"

namespace dccast::mechanics {

/// The melt beside the metal that carries load. It is no part of the mechanical body: it presses on
/// the body, and its nodes follow.
template <int Dim>
class Melt {
public:
  using Mesh = mesh::Mesh<Dim>;

  /// Sets the mesh, or updates its coordinates. The mesh must not move in memory.
  /// @param is_new  it has other elements than before
  void set_mesh(const Mesh& mesh, bool is_new);

  /// Elements that carry load: the coherent ones of the pieces that stand on the bottom and reach
  /// every plane of symmetry. A piece that does not has no support sideways: it drifts in the melt.
  /// Elements are joined by whole facets; at an edge or a node they are hinged.
  /// @param coherent  (element) not zero: below the coherency temperature
  /// @return          (element)
  std::vector<char> carrying(std::span<const char> coherent) const;

  /// Adds the pressure of the melt on the facets of the metal that carries load. A pool that
  /// reaches the top of the slab stands to the metal level, a closed one to its own highest node.
  /// @param carries          (element)
  /// @param metal_level      [m]
  /// @param specific_weight  of the melt [N/m3]
  /// @return                 downward resultant [unit of the forces]
  double press(const MechanicsForms<Dim>& forms, std::span<const char> carries, double metal_level,
               double specific_weight, std::span<double> force);
  /// Height to which the melt of an element's pool stands [m]. @pre press() has been called
  double surface(int element) const { return surface_[std::size_t(element)]; }

  /// Moves the free nodes as those of a weak elastic body without stress of its own. They depend on
  /// the displacement of the others alone, not on that of earlier steps.
  /// @param forms         without rotations of melt; all elements take part on return
  /// @param carries       (element)
  /// @param held          (unknown) not zero: keeps its displacement
  /// @param displacement  by unknown [m]
  void follow(MechanicsForms<Dim>& forms, std::span<const char> carries,
              const linalg::SparsityPattern& pattern, std::span<const char> held,
              std::span<double> displacement);

private:
  /// Stiffness of that body.
  void assemble(const MechanicsForms<Dim>& forms, std::span<const char> carries,
                const linalg::SparsityPattern& pattern);

  const Mesh* mesh_ = nullptr;
  std::vector<mesh::InnerFacet<Dim>> inner_;
  std::vector<unsigned> supported_by_;  ///< (element) bit 0: the bottom, then symmetry planes
  std::vector<char> at_top_;            ///< (element)
  unsigned all_supports_ = 0;           ///< bits of the bottom and of every plane
  std::vector<double> surface_;         ///< (element) @see surface() [m]
  std::vector<double> stiffness_;       ///< (entry of the pattern) of the melt
  linalg::GradientVectors<double> gradients_;
};

}  // namespace dccast::mechanics
