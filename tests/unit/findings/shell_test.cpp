#include "core/casting/findings/shell.hpp"

#include <gtest/gtest.h>

#include <vector>

#include "core/mesh/slab_mesh.hpp"
#include "tests/support/print_kinds.hpp"

namespace dccast::casting {
namespace {

/// 7 columns of 40 mm and 5 rows of 20 mm.
mesh::SectionSpec even_cells(mesh::ElementKind element) {
  mesh::SectionSpec spec;
  spec.half_width = 0.28;
  spec.initial_depth = 0.10;
  spec.element = element;
  spec.columns = 7;
  spec.rows = 5;
  spec.side_cell = 0.04;
  spec.bottom_cell = 0.02;
  return spec;
}

class Shell : public ::testing::TestWithParam<mesh::ElementKind> {
protected:
  const mesh::SlabMesh2D slab{even_cells(GetParam())};
  std::vector<char> solid = std::vector<char>(std::size_t(slab.mesh().elements()), 0);

  int elements_in_cell() const {
    return slab.mesh().elements() / (slab.rows() * slab.cells_per_row());
  }
  void set(int column, int row, bool is_solid) {
    const int cell = row * slab.cells_per_row() + column;
    for (int i = 0; i < elements_in_cell(); ++i)
      solid[std::size_t(cell * elements_in_cell() + i)] = is_solid ? 1 : 0;
  }
  void fill_rows(int rows) {
    for (int row = 0; row < rows; ++row)
      for (int column = 0; column < slab.cells_per_row(); ++column) set(column, row, true);
  }
  PlacedFigure thinnest() const { return thinnest_shell(slab.mesh(), solid).value(); }
};

TEST_P(Shell, OfMeltAloneThereIsNone) {
  EXPECT_EQ(thinnest().value, 0.0);
}

TEST_P(Shell, IsAsThickAsItsRows) {
  fill_rows(2);
  EXPECT_NEAR(thinnest().value, 0.04, 1e-12);
  fill_rows(5);
  EXPECT_NEAR(thinnest().value, 0.10, 1e-12) << "solid to the top";
}

TEST_P(Shell, StandsWhereNoMeltTouchesTheBottom) {
  EXPECT_TRUE(melt_touches_bottom(slab.mesh(), solid));
  fill_rows(1);
  EXPECT_FALSE(melt_touches_bottom(slab.mesh(), solid));
  EXPECT_GT(thinnest().value, 0.0);
  set(5, 0, false);
  EXPECT_TRUE(melt_touches_bottom(slab.mesh(), solid));
}

TEST_P(Shell, IsThinnestWhereTheMeltComesDown) {
  fill_rows(3);
  set(4, 2, false);
  set(4, 1, false);
  EXPECT_NEAR(thinnest().value, 0.02, 1e-12);
  EXPECT_GE(thinnest().place[0], 0.16 - 1e-12);
  EXPECT_LE(thinnest().place[0], 0.20 + 1e-12);
  EXPECT_EQ(thinnest().place[1], 0.0);
}

TEST_P(Shell, IsCutThroughByOneMoltenColumn) {
  fill_rows(3);
  for (int row = 0; row < 3; ++row) set(2, row, false);
  EXPECT_EQ(thinnest().value, 0.0);
  EXPECT_NEAR(thinnest().place[0], 0.10, 0.02 + 1e-12);
}

/// Neither does a column that is molten at the symmetry plane leave a path from it, nor one at the
/// side a path to the faces.
TEST_P(Shell, IsCutThroughAtItsEndsToo) {
  fill_rows(3);
  for (int row = 0; row < 3; ++row) set(0, row, false);
  EXPECT_EQ(thinnest().value, 0.0);
  fill_rows(3);
  for (int row = 0; row < 5; ++row) set(6, row, false);
  EXPECT_EQ(thinnest().value, 0.0);
}

/// A way round above a pocket of melt at the bottom is a way.
TEST_P(Shell, PassesOverAPocketOfMelt) {
  fill_rows(4);
  set(3, 0, false);
  set(3, 1, false);
  EXPECT_NEAR(thinnest().value, 0.04, 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Elements, Shell,
                         ::testing::Values(mesh::ElementKind::p1, mesh::ElementKind::q1));

/// Left half two rows high, right half rows three and four: they touch in one node.
TEST(ShellOfQuadrilaterals, DoesNotHoldByACornerAlone) {
  const mesh::SlabMesh2D slab(even_cells(mesh::ElementKind::q1));
  std::vector<char> solid(std::size_t(slab.mesh().elements()), 0);
  for (int row = 0; row < 4; ++row)
    for (int column = 0; column < 7; ++column)
      solid[std::size_t(row * 7 + column)] = (row < 2) == (column < 4) ? 1 : 0;
  EXPECT_EQ(thinnest_shell(slab.mesh(), solid)->value, 0.0);
  solid[std::size_t(2 * 7 + 3)] = 1;  // one cell more, and they share an edge
  EXPECT_GT(thinnest_shell(slab.mesh(), solid)->value, 0.0);
}

TEST(ShellOfAnImportedMesh, IsNotKnownWithoutABottom) {
  mesh::Mesh2D mesh = mesh::SlabMesh2D(even_cells(mesh::ElementKind::q1)).mesh();
  mesh.facets(mesh::PatchKind::bottom).clear();
  EXPECT_FALSE(thinnest_shell(mesh, std::vector<char>(std::size_t(mesh.elements()), 1)));
}

}  // namespace
}  // namespace dccast::casting
