#pragma once

#include <optional>
#include <vector>

#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"
#include "tests/verification/mechanics/figures.hpp"

namespace dccast::verification {

/// The fictitious liquid of eq. (38): lambda = epsilon^beta * 1e4 Pa, mu = epsilon^delta * 10 Pa.
struct FictitiousLiquid {
  double epsilon = 1e-3;
  double delta = 2.0;
  double beta = 1.0;
};

/// How cells are cut into triangles. Mirrored: rising on the left half, falling on the right.
enum class Diagonals { rising, falling, mirrored, mirrored_back };

/// Test T1, section 3.4.1: a linear elastic solid under metallostatic pressure.
struct T1Run {
  int columns = 40;  ///< across the slab, even: the front's kink lies on a node
  int rows = 48;     ///< of the solid, a multiple of 6: the change of side condition lies on a node
  int liquid_rows = 48;  ///< in the middle of the slab the liquid is as deep as the solid
  Diagonals diagonals = Diagonals::mirrored;
  mesh::ElementKind element = mesh::ElementKind::p1;
  std::optional<FictitiousLiquid> liquid;  ///< absent: pressure given on the front
};

/// Relative errors over a part of the solid.
struct PartErrors {
  double displacement = 0.0;      ///< L2
  double displacement_max = 0.0;  ///< largest nodal error over the largest nodal displacement
  double stress = 0.0;            ///< L2
  double stress_max = 0.0;        ///< largest error at a centroid over the largest exact stress
};

struct T1Result {
  PartErrors whole;
  PartErrors away;  ///< at least 0.1 m from the front
  double pressure_on_front_error =
      0.0;  ///< largest, of the liquid's pressure, over the largest p_r
  int solid_elements = 0;
  int nodes = 0;
  double cpu_s = 0.0;
  mesh::Mesh2D mesh;
  std::vector<double> shear_stress;  ///< sigma_23 by element, mean over its points [Pa]
};

/// @throws std::invalid_argument  for a mesh on which the data have no node
/// @throws std::runtime_error     when the linear problem could not be solved
T1Result run_t1(const T1Run& run);

}  // namespace dccast::verification
