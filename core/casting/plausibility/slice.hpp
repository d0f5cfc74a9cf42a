#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/casting/plausibility/bottom_shell.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// The slab cut across at one height.
template <int Dim>
struct Slice {
  double hottest_surface = 0.0;          ///< [°C] of the side
  std::array<double, Dim> hottest_at{};  ///< [m]
  double shell = 0.0;  ///< [m] least distance from the side to metal at the isotherm
  std::array<double, Dim> thinnest_at{};  ///< [m] on that metal
};

/// Cuts the mesh and looks at its side. Temperatures are linear along the edges of elements and
/// between the points where an edge meets the cut.
///
/// Where the side itself is hotter than the isotherm the shell is zero; without such metal at this
/// height it is as thick as the slab, measured from the side.
/// @param temperature  (node) [°C]
/// @param height       [m] above the bottom of the undeformed slab
/// @param isotherm     [°C]
/// @return             nothing where the slab has no side at that height
template <int Dim>
std::optional<Slice<Dim>> slice_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                                   double height, double isotherm);

/// The hottest place of the side at a height, with its temperature [°C]: what slice_at says of the
/// surface, without a look at every element.
/// @return  nothing where the slab has no side at that height
template <int Dim>
std::optional<Located<Dim>> hottest_side_at(const mesh::Mesh<Dim>& mesh,
                                            std::span<const double> temperature, double height);

extern template std::optional<Slice<2>> slice_at(const mesh::Mesh<2>&, std::span<const double>,
                                                 double, double);
extern template std::optional<Slice<3>> slice_at(const mesh::Mesh<3>&, std::span<const double>,
                                                 double, double);
extern template std::optional<Located<2>> hottest_side_at(const mesh::Mesh<2>&,
                                                          std::span<const double>, double);
extern template std::optional<Located<3>> hottest_side_at(const mesh::Mesh<3>&,
                                                          std::span<const double>, double);

}  // namespace dccast::casting
