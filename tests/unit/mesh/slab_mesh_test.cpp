#include "core/mesh/slab_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <stdexcept>

#include "core/mesh/bottom_normals.hpp"
#include "core/mesh/extrusion.hpp"
#include "tests/support/print_kinds.hpp"

namespace dccast::mesh {
namespace {

SectionSpec small_section(ElementKind element) {
  SectionSpec spec;
  spec.half_width = 0.28;
  spec.initial_depth = 0.10;
  spec.element = element;
  spec.columns = 7;
  spec.rows = 5;
  spec.side_cell = 0.01;
  spec.bottom_cell = 0.008;
  spec.growth_cell = 0.012;
  return spec;
}

double polygon_area(const Mesh2D& mesh, int e) {
  double twice = 0.0;
  for (int i = 0; i < mesh.nodes_per_element; ++i) {
    const double* a = mesh.point(mesh.nodes_of(e)[i]);
    const double* b = mesh.point(mesh.nodes_of(e)[(i + 1) % mesh.nodes_per_element]);
    twice += a[0] * b[1] - b[0] * a[1];
  }
  return 0.5 * twice;
}

void expect_to_cover(const Mesh2D& mesh, double width, double height) {
  double sum = 0.0;
  for (int e = 0; e < mesh.elements(); ++e) {
    ASSERT_GT(polygon_area(mesh, e), 0.0) << "element " << e;
    sum += polygon_area(mesh, e);
  }
  EXPECT_NEAR(sum, width * height, 1e-13);
}

/// The facets of all patches form one closed line around the section, the domain on its left; each
/// is an edge of the element it names, in that element's own direction.
void expect_closed_boundary(const Mesh2D& mesh, double width, double height) {
  std::map<int, int> next;
  double twice = 0.0;  // the area by Green's theorem

  for (const auto& patch : mesh.patches) {
    for (const auto& facet : patch.facets) {
      ASSERT_TRUE(next.emplace(facet.node[0], facet.node[1]).second) << "two facets leave one node";
      const double *a = mesh.point(facet.node[0]), *b = mesh.point(facet.node[1]);
      twice += a[0] * b[1] - b[0] * a[1];

      const int* node = mesh.nodes_of(facet.element);
      bool edge = false;
      for (int i = 0; i < mesh.nodes_per_element; ++i) {
        edge |= node[i] == facet.node[0] && node[(i + 1) % mesh.nodes_per_element] == facet.node[1];
      }
      EXPECT_TRUE(edge) << "element " << facet.element;
    }
  }
  EXPECT_NEAR(0.5 * twice, width * height, 1e-13);

  // Follow the facets around the section.
  int node = next.begin()->first;
  std::size_t length = 0;
  do {
    ASSERT_TRUE(next.count(node)) << "the boundary is open";
    node = next[node];
    ++length;
  } while (node != next.begin()->first && length <= next.size());
  EXPECT_EQ(length, next.size()) << "the boundary is one loop";
}

void expect_patches_in_place(const Mesh2D& mesh, double width, double height) {
  for (int n : patch_nodes(mesh, PatchKind::symmetry)) EXPECT_EQ(mesh.point(n)[0], 0.0);
  for (int n : patch_nodes(mesh, PatchKind::side)) EXPECT_EQ(mesh.point(n)[0], width);
  for (int n : patch_nodes(mesh, PatchKind::bottom)) EXPECT_EQ(mesh.point(n)[1], 0.0);
  for (int n : patch_nodes(mesh, PatchKind::top)) EXPECT_EQ(mesh.point(n)[1], height);
}

void expect_same(const Mesh2D& a, const Mesh2D& b) {
  EXPECT_EQ(a.node, b.node);
  EXPECT_EQ(a.element_node, b.element_node);

  ASSERT_EQ(a.patches.size(), b.patches.size());
  for (std::size_t p = 0; p < a.patches.size(); ++p) {
    const auto &first = a.patches[p].facets, &second = b.patches[p].facets;
    ASSERT_EQ(first.size(), second.size()) << a.patches[p].name;
    for (std::size_t i = 0; i < first.size(); ++i) {
      EXPECT_EQ(first[i].node, second[i].node);
      EXPECT_EQ(first[i].element, second[i].element);
    }
  }
}

TEST(GradedCells, SumToTheirLengthAndGrowByOneFactor) {
  for (const auto& [length, cells, first] : {std::tuple{0.28, 30, 3e-3},
                                             {0.1, 22, 3e-3},
                                             {0.1, 5, 0.02},
                                             {0.1, 5, 0.05},
                                             {1.0, 1, 0.3}}) {
    const auto widths = graded_cells(length, cells, first);
    ASSERT_EQ(widths.size(), std::size_t(cells));
    EXPECT_NEAR(std::accumulate(widths.begin(), widths.end(), 0.0), length, 1e-14 * cells);

    if (cells > 1) {
      EXPECT_NEAR(widths[0], first, 1e-10 * first);
    }
    for (int i = 2; i < cells; ++i) {
      EXPECT_NEAR(widths[i] / widths[i - 1], widths[1] / widths[0], 1e-10);
    }
  }
}

class Slab : public ::testing::TestWithParam<ElementKind> {};

TEST_P(Slab, HasTheNumbersItsSpecAsksFor) {
  SectionSpec spec = small_section(GetParam());
  const int per_cell = GetParam() == ElementKind::p1 ? 2 : 1;
  for (int refinement : {1, 3}) {
    spec.refinement = refinement;
    const SlabMesh2D slab(spec);
    EXPECT_EQ(slab.cells_per_row(), 7 * refinement);
    EXPECT_EQ(slab.rows(), 5 * refinement);
    EXPECT_EQ(slab.mesh().nodes(), (7 * refinement + 1) * (5 * refinement + 1));
    EXPECT_EQ(slab.mesh().elements(), per_cell * 35 * refinement * refinement);
    EXPECT_EQ(slab.level(), 0.10);

    expect_to_cover(slab.mesh(), 0.28, 0.10);
    expect_closed_boundary(slab.mesh(), 0.28, 0.10);
    expect_patches_in_place(slab.mesh(), 0.28, 0.10);
  }
}

/// numerics 3: cells of a given size where metal is cooled, larger ones inside.
TEST_P(Slab, IsFineAtTheSideAndAtTheBottom) {
  const SlabMesh2D slab(small_section(GetParam()));
  const Mesh2D& mesh = slab.mesh();
  EXPECT_NEAR(mesh.point(7)[0] - mesh.point(6)[0], 0.01, 1e-9);
  EXPECT_GT(mesh.point(1)[0], 0.05);
  EXPECT_NEAR(mesh.point(8)[1], 0.008, 1e-9);
}

TEST_P(Slab, RefinementDividesTheCoarseCells) {
  SectionSpec spec = small_section(GetParam());
  const SlabMesh2D coarse(spec);
  spec.refinement = 2;
  const SlabMesh2D fine(spec);
  for (int row = 0; row <= 5; ++row) {
    for (int column = 0; column <= 7; ++column) {
      const double* a = coarse.mesh().point(row * 8 + column);
      const double* b = fine.mesh().point(2 * row * 15 + 2 * column);
      EXPECT_EQ(a[0], b[0]);
      EXPECT_EQ(a[1], b[1]);
    }
  }
}

TEST_P(Slab, GrowthOnlyAppends) {
  SlabMesh2D slab(small_section(GetParam()));
  double level = 0.10;
  for (double rise : {1e-4, 0.003, 0.0, 0.02, 0.011, 0.05, 1e-12, 0.0049}) {
    const Mesh2D before = slab.mesh();
    const auto heights = slab.row_heights();
    const int old_rows = slab.rows();

    level += rise;
    const auto between = slab.grow_to(level);
    const Mesh2D& after = slab.mesh();
    EXPECT_EQ(slab.level(), level);
    EXPECT_EQ(slab.rows(), old_rows + static_cast<int>(between.size()));

    // Rows below the top one keep their heights; that of the top row of nodes changes.
    for (std::size_t i = 0; i + 1 < heights.size(); ++i)
      EXPECT_EQ(slab.row_heights()[i], heights[i]);

    // Existing nodes and elements keep their numbers.
    const std::size_t fixed = 2 * std::size_t(slab.nodes_per_row()) * std::size_t(old_rows);
    ASSERT_GE(after.node.size(), before.node.size());
    EXPECT_TRUE(
        std::equal(before.node.begin(), before.node.begin() + long(fixed), after.node.begin()));
    ASSERT_GE(after.element_node.size(), before.element_node.size());
    EXPECT_TRUE(std::equal(before.element_node.begin(), before.element_node.end(),
                           after.element_node.begin()));

    for (std::size_t i = 0; i < between.size(); ++i) {
      EXPECT_EQ(slab.row_heights()[heights.size() - 1 + i], between[i]);
    }
    EXPECT_LE(level - slab.row_heights()[slab.row_heights().size() - 2], 1.5 * 0.012 + 1e-15);

    expect_to_cover(after, 0.28, level);
    expect_closed_boundary(after, 0.28, level);
    expect_patches_in_place(after, 0.28, level);
  }
}

TEST_P(Slab, RestoredEqualsGrown) {
  SlabMesh2D grown(small_section(GetParam()));
  for (double level : {0.104, 0.121, 0.1211, 0.18, 0.1999}) {
    grown.grow_to(level);

    SlabMesh2D restored(small_section(GetParam()));
    restored.grow_to(0.3);  // its former state does not matter
    restored.restore(grown.row_heights());
    expect_same(restored.mesh(), grown.mesh());
    EXPECT_EQ(restored.rows(), grown.rows());

    // Both continue in the same way.
    SlabMesh2D copy = grown;
    copy.grow_to(level + 0.0177);
    restored.grow_to(level + 0.0177);
    expect_same(restored.mesh(), copy.mesh());
  }
}

TEST_P(Slab, RowsAreForetoldForSmallAndLargeSteps) {
  const SectionSpec spec = small_section(GetParam());
  SlabMesh2D by_small(spec);
  for (int i = 1; i <= 700; ++i) {
    const double level = 0.10 + 3.3e-4 * i;
    by_small.grow_to(level);
    EXPECT_EQ(rows_at(spec, level), by_small.rows()) << level;
    if (i % 50 != 0) continue;

    SlabMesh2D at_once(spec);
    at_once.grow_to(level);
    EXPECT_EQ(at_once.rows(), by_small.rows()) << level;
    for (int row = 0; row <= at_once.rows(); ++row) {
      EXPECT_NEAR(at_once.row_heights()[std::size_t(row)], by_small.row_heights()[std::size_t(row)],
                  1e-14);
    }
  }
}

/// Regardless of the speed of filling, the full mould has the planned rows, and growth continues as
/// if it had been full from the start.
TEST_P(Slab, FillingEndsWithThePlannedRows) {
  for (const int steps : {1, 3, 40, 500}) {
    SlabMesh2D full(small_section(GetParam())), filled(small_section(GetParam()));
    filled.start_filling();
    EXPECT_EQ(filled.rows(), 2);
    const double first = filled.level(), last = filled.planned_level();
    EXPECT_EQ(last, full.level());

    for (int k = 1; k <= steps; ++k) {
      filled.grow_to(k == steps ? last : first + (last - first) * k / steps);
      const auto& heights = filled.row_heights();
      EXPECT_TRUE(std::ranges::is_sorted(heights, std::less_equal{}));
      EXPECT_GT(heights.back() - heights[heights.size() - 2], 0.4 * heights[1]);
    }

    EXPECT_EQ(filled.row_heights(), full.row_heights()) << steps;
    EXPECT_EQ(filled.mesh().element_node, full.mesh().element_node);

    full.grow_to(last + 0.02);
    filled.grow_to(last + 0.02);
    EXPECT_EQ(filled.row_heights(), full.row_heights());
  }
}

TEST_P(Slab, TheLevelCannotSink) {
  SlabMesh2D slab(small_section(GetParam()));
  EXPECT_THROW(slab.grow_to(0.09), std::logic_error);
}

INSTANTIATE_TEST_SUITE_P(Elements, Slab, ::testing::Values(ElementKind::p1, ElementKind::q1));

/// The metal fills the bowl: the section below the metal level is larger by the bowl's own, and
/// rows are flat from about its depth on.
TEST(SlabMesh, LowestRowsFollowABowl) {
  SectionSpec spec = small_section(ElementKind::q1_bending);
  spec.refinement = 32;  // cells below 2 mm
  spec.bowl = {.depth = 0.03, .lip = 0.04, .wall = 0.12};
  SlabMesh2D slab(spec);
  slab.grow_to(0.13);
  const Mesh2D& mesh = slab.mesh();

  double area = 0.0;
  for (int e = 0; e < mesh.elements(); ++e) {
    ASSERT_GT(polygon_area(mesh, e), 0.0) << "element " << e;
    area += polygon_area(mesh, e);
  }
  const double bowl = 0.03 * (0.28 - 0.04 - 0.5 * 0.12);
  EXPECT_NEAR(area, 0.28 * 0.13 + bowl, 1e-4 * bowl);

  for (int n = 0; n < mesh.nodes(); ++n) {
    const std::size_t row = std::size_t(n / slab.nodes_per_row());
    const double over_lip = slab.row_heights()[row], height = mesh.point(n)[1];
    const double deepest = -spec.bowl->depth_at(0.28 - mesh.point(n)[0]);
    if (row == 0 || over_lip >= 0.04) {
      EXPECT_DOUBLE_EQ(height, row == 0 ? deepest : over_lip);
    }
  }
}

TEST(SlabMesh, NormalsOfTheBottomAreThoseOfTheBowl) {
  SectionSpec spec = small_section(ElementKind::q1);
  spec.refinement = 32;  // cells below 2 mm
  spec.bowl = {.depth = 0.03, .lip = 0.04, .wall = 0.12};
  const SlabMesh2D slab(spec);
  const std::vector<int> bottom = patch_nodes(slab.mesh(), PatchKind::bottom);
  const auto normals = inward_normals(slab.mesh(), bottom);

  for (std::size_t i = 0; i < bottom.size(); ++i) {
    const double inward = 0.28 - slab.mesh().point(bottom[i])[0];
    const double share = std::clamp((inward - 0.04) / 0.12, 0.0, 1.0);
    const double slope =
        0.5 * 0.03 * M_PI / 0.12 * std::sin(M_PI * share);  // the block rises along x
    EXPECT_NEAR(normals[i][0], -slope / std::hypot(1.0, slope), 5e-3) << inward;
    EXPECT_GT(normals[i][1], 0.9);
    if (inward < 0.03) {
      EXPECT_EQ(normals[i][1], 1.0) << "flat lip";
    }
  }
}

}  // namespace
}  // namespace dccast::mesh
