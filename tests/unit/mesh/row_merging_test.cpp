// Rows of a grown mesh that are merged in pairs.
#include "core/mesh/row_merging.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "core/mesh/slab_mesh.hpp"

namespace dccast::mesh {
namespace {

std::vector<double> even_rows(std::size_t cells, double height) {
  std::vector<double> rows(cells + 1);
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = height * static_cast<double>(i);
  return rows;
}

TEST(RowMerging, TakesPairsThatLieDeepEnough) {
  const std::vector<double> rows = even_rows(20, 0.01);
  EXPECT_EQ(rows_to_merge(rows, 0, {0.121, 0.02}), (std::vector{1, 3, 5}))
      << "the level is 0.2 m: pairs whose upper edge is below 0.079 m";
  EXPECT_EQ(rows_to_merge(rows, 3, {0.121, 0.02}), (std::vector{4, 6}));
  EXPECT_TRUE(rows_to_merge(rows, 0, {0.0, 0.02}).empty()) << "switched off";
}

TEST(RowMerging, LetsARowBeAsHighAsAFifthOfItsDepth) {
  const std::vector<double> rows = even_rows(20, 0.01);
  EXPECT_EQ(rows_to_merge(rows, 0, {0.01, 0.019}), (std::vector{1, 3, 5, 7, 9}))
      << "pairs of 0.02 m whose upper edge is 0.1 m below the level or deeper";
  EXPECT_EQ(rows_to_merge(rows, 0, {0.15, 0.001}), (std::vector{1, 3}));
}

TEST(RowMerging, NeverTouchesTheRowsThatGrow) {
  for (const std::size_t cells : {2u, 3u, 4u, 5u}) {
    for (const int row : rows_to_merge(even_rows(cells, 0.01), 0, {1e-9, 1.0}))
      EXPECT_LE(std::size_t(row) + 1, cells - 2) << cells;
  }
}

TEST(RowMerging, WaitsUntilOneRowIn32CanBeRemoved) {
  const std::vector<double> rows = even_rows(65, 0.01);  // 66 rows of nodes: three at once
  EXPECT_TRUE(rows_to_merge(rows, 0, {0.609, 0.02}).empty()) << "two pairs lie deep enough";
  EXPECT_EQ(rows_to_merge(rows, 0, {0.589, 0.02}), (std::vector{1, 3, 5}));
}

TEST(RowMerging, MergesOnlyRowsOfOneHeight) {
  std::vector<double> rows{0.0, 0.02, 0.03, 0.04, 0.06, 0.08, 0.09};
  for (int i = 1; i <= 6; ++i) rows.push_back(0.09 + 0.01 * i);
  EXPECT_EQ(rows_to_merge(rows, 0, {0.055, 0.04}), (std::vector{2, 4}));
}

TEST(RowMerging, SaysWhatRowsAreMadeOf) {
  const MergedRows merged{even_rows(5, 0.01), {1, 4}, 3, 2};
  const std::vector<std::array<std::size_t, 2>> expected{{0, 1}, {2, 2}, {3, 4}};
  EXPECT_EQ(merged.made_of(), expected);
  std::vector<int> field(18);
  std::iota(field.begin(), field.end(), 0);
  take_out_rows(merged, 3, field);
  EXPECT_EQ(field, (std::vector{0, 1, 2, 6, 7, 8, 9, 10, 11, 15, 16, 17}));
}

SectionSpec slab_that_merges(ElementKind kind) {
  SectionSpec spec;
  spec.kind = SectionKind::quarter_slab;
  spec.half_width = 0.3;
  spec.half_thickness = Curve(0.15);
  spec.initial_depth = 0.06;
  spec.element = kind;
  spec.columns = 3;
  spec.layers = 2;
  spec.rows = 5;
  spec.side_cell = spec.wide_side_cell = 0.04;
  spec.bottom_cell = 0.01;
  spec.growth_cell = 5e-3;
  spec.merging = {0.05, 0.02};
  return spec;
}

TEST(RowMerging, AMergedMeshIsTheMeshOfItsRows) {
  const SectionSpec spec = slab_that_merges(ElementKind::q1);
  SlabMesh3D slab(spec);
  int merged_rows = 0;
  for (int i = 1; i <= 100; ++i) {
    const MergedRows merged = slab.rows_to_merge();
    merged_rows += static_cast<int>(merged.taken_out.size());
    if (!merged.empty()) slab.merge(merged);
    slab.grow_to(0.06 + 2.2e-3 * i);
    SlabMesh3D afresh(spec);
    afresh.restore(slab.row_heights());
    ASSERT_EQ(afresh.mesh().node, slab.mesh().node) << i;
    ASSERT_EQ(afresh.mesh().element_node, slab.mesh().element_node) << i;
    for (std::size_t p = 0; p < slab.mesh().patches.size(); ++p)
      ASSERT_EQ(afresh.mesh().patches[p].facets.size(), slab.mesh().patches[p].facets.size());
    EXPECT_NEAR(rows_at(spec, slab.level()), slab.rows(), 2) << i;
  }
  EXPECT_GT(merged_rows, 20);

  const auto& rows = slab.row_heights();
  EXPECT_NEAR(rows[6] - rows[5], 0.02, 1e-12) << "above the initial rows, of which one has grown";

  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double cell = rows[i] - rows[i - 1];
    EXPECT_LE(cell, 0.02 + 1e-12);
    if (slab.level() - rows[i] < 0.05) {
      EXPECT_LE(cell, 0.0075 + 1e-12) << "fine near the level";
    }
  }
}

}  // namespace
}  // namespace dccast::mesh
