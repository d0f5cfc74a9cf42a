// Merging of rows conserves heat.
#include "core/thermal/growth.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/mesh/slab_mesh.hpp"
#include "core/thermal/heat_forms.hpp"

namespace dccast::thermal {
namespace {

mesh::SectionSpec slab_of_even_rows() {
  mesh::SectionSpec spec;
  spec.kind = mesh::SectionKind::quarter_slab;
  spec.half_width = 0.3;
  spec.half_thickness = {Abscissa::distance, {0.0, 0.2, 0.3}, {0.15, 0.14, 0.12}};
  spec.initial_depth = 0.12;
  spec.element = mesh::ElementKind::q1;
  spec.columns = 3;
  spec.layers = 2;
  spec.rows = 12;
  spec.side_cell = spec.wide_side_cell = 0.04;
  spec.bottom_cell = 0.01;
  return spec;
}

/// A slab of twelve rows of 10 mm, and its enthalpy.
struct Slab {
  mesh::SlabMesh3D mesh{slab_of_even_rows()};
  std::unique_ptr<HeatForms> forms = make_heat_forms(mesh.mesh());
  std::vector<double> enthalpy;

  template <class Profile>
  explicit Slab(const Profile& profile) {
    forms->update();
    for (int n = 0; n < mesh.mesh().nodes(); ++n) enthalpy.push_back(profile(n, height(n)));
  }
  double height(int n) const { return mesh.mesh().point(n)[2]; }
  double heat() const { return heat_content(forms->volume(), enthalpy); }
  void merge(std::vector<int> rows) {
    const mesh::MergedRows merged{mesh.row_heights(), std::move(rows),
                                  std::size_t(mesh.nodes_per_row()),
                                  std::size_t(mesh.elements_per_row())};
    mesh.merge(merged);
    forms->follow_merging(merged, enthalpy);
  }
};

TEST(RowMerging, KeepsTheHeatAndTheRange) {
  Slab slab([](int n, double) { return n % 3 == 0 ? 1.2e9 : n % 3 == 1 ? 2.9e9 : 2.0e9; });
  const double before = slab.heat();
  slab.merge({2, 5, 7});
  ASSERT_EQ(int(slab.enthalpy.size()), slab.mesh.mesh().nodes());
  EXPECT_NEAR(slab.heat() / before, 1.0, 1e-14);
  EXPECT_GE(*std::ranges::min_element(slab.enthalpy), 1.2e9 * (1.0 - 1e-14));
  EXPECT_LE(*std::ranges::max_element(slab.enthalpy), 2.9e9 * (1.0 + 1e-14));
}

/// Several mergings in a row: the heat that a node receives from a removed neighbour below
/// compensates that of a removed neighbour above. Only the ends of the merged range keep a
/// difference.
TEST(RowMerging, ALinearProfileIsLinearAgainOnceItsNeighboursAreMergedToo) {
  Slab slab([](int, double z) { return 1e9 + 5e9 * z; });
  slab.merge({2});
  slab.merge({3});
  slab.merge({4});
  for (std::size_t n = 0; n < slab.enthalpy.size(); ++n) {
    const double z = slab.height(static_cast<int>(n));
    const bool inside = z > 0.02 && z < 0.065;
    if (inside) {
      EXPECT_NEAR(slab.enthalpy[n] / (1e9 + 5e9 * z), 1.0, 1e-14) << z;
    }
  }
}

/// Only what lies above the lowest merged row is integrated anew.
TEST(RowMerging, LeavesTheFormsOfTheMergedMeshToTheLastBit) {
  Slab slab([](int, double) { return 1.7e9; });
  slab.merge({7});
  slab.merge({5, 8});

  const auto anew = make_heat_forms(slab.mesh.mesh());
  anew->update();
  EXPECT_EQ(slab.forms->volume(), anew->volume());
  EXPECT_EQ(slab.forms->pattern().row(), anew->pattern().row());
  EXPECT_TRUE(std::ranges::equal(slab.forms->stiffness(), anew->stiffness()));
}

TEST(RowMerging, AUniformFieldStaysUniform) {
  Slab slab([](int, double) { return 1.7e9; });
  slab.merge({1, 3, 9});
  for (const double h : slab.enthalpy) EXPECT_NEAR(h / 1.7e9, 1.0, 1e-14);
}

}  // namespace
}  // namespace dccast::thermal
