#pragma once

#include <array>
#include <optional>
#include <span>

#include "core/findings/shell.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::casting {

/// A horizontal cut through the slab.
template <int Dim>
struct Slice {
  double hottest_surface = 0.0;           ///< [°C] of the side
  std::array<double, Dim> hottest_at{};   ///< [m]
  double shell = 0.0;                     ///< [m] smallest distance from the side to the isotherm
  std::array<double, Dim> thinnest_at{};  ///< [m] where the shell is thinnest, on the isotherm
};

/// Cuts the mesh at a height. Temperatures are linear along the edges of elements and between the
/// points where the edges meet the cut.
///
/// If the side itself is hotter than the isotherm, the shell is zero. If no metal at this height is
/// that hot, the shell is as thick as the slab, measured from the side.
/// @param temperature  (node) [°C]
/// @param height       [m] above the bottom of the undeformed slab
/// @param isotherm     [°C]
/// @return             empty if the slab has no side at that height
template <int Dim>
std::optional<Slice<Dim>> slice_at(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                                   double height, double isotherm);

/// The hottest point of the side at a height and its temperature [°C]: the same as slice_at()
/// finds, without visiting every element.
/// @param temperature  (node) [°C]
/// @param height       [m] above the bottom of the undeformed slab
/// @return             empty if the slab has no side at that height
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

/// Largest temperature of the sides at a height above the bottom block, linear between nodes [°C].
/// Above and below the sides the value at their end is used; 0 if the mesh has no named sides.
/// @param temperature  (node) [°C]
/// @param height       [m]
template <int Dim>
double side_temperature(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                        double height);

/// Depth of the sump [m]: distance below the metal level at which the centre of the slab, where
/// most symmetry planes meet, first falls below the isotherm; the whole depth if it never does.
/// @param temperature  (node) [°C]
/// @param metal_level  [m]
/// @param isotherm     [°C]
template <int Dim>
double sump_depth(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                  double metal_level, double isotherm);

extern template double side_temperature(const mesh::Mesh<2>&, std::span<const double>, double);
extern template double side_temperature(const mesh::Mesh<3>&, std::span<const double>, double);
extern template double sump_depth(const mesh::Mesh<2>&, std::span<const double>, double, double);
extern template double sump_depth(const mesh::Mesh<3>&, std::span<const double>, double, double);

}  // namespace dccast::casting
