#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "core/mechanics/options.hpp"
#include "core/mesh/mesh.hpp"
#include "core/mesh/section_spec.hpp"
#include "tests/support/usual_options.hpp"
#include "tests/verification/mechanics/figures.hpp"

namespace dccast::verification {

/// How one of the paper's tests is run.
struct TestRun {
  mechanics::Options options = testing::usual_options(1e-8);
  double dt = 0.0625;  ///< [s]
  int cells = 0;       ///< per side; 0: the paper's mesh
  mesh::ElementKind element = mesh::ElementKind::p1;
  std::optional<double> end;  ///< [s]; absent: the paper's
  /// Halve a step that fails; absent: unless plain.
  std::optional<bool> cut_steps;
};

using Result = std::variant<Figures, Failed>;

/// Test T3, section 4.3.2: Maxwell-Norton in plane strain, homogeneous stress linear in time.
Result run_t3(const TestRun& run);
/// Test T4, section 4.3.4: T3 with Signorini contact at the bottom.
Result run_t4(const TestRun& run);
/// Test T2, section 4.3.1: thermo-elastic contact with a moving gap.
Result run_t2(const TestRun& run);

/// T2 at its end, as the paper's figure 13 shows it.
struct DeformedSquare {
  mesh::Mesh2D mesh;          ///< moved by the displacement
  std::vector<double> shift;  ///< (element) mean modulus of the displacement [m]
  std::vector<double> mises;  ///< (element) von Mises' stress [Pa]
};
/// @param cells  per side
DeformedSquare deform_t2(int cells);

}  // namespace dccast::verification
