#include "core/mechanics/melt.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double specific_weight = 2.4e4;  // [N/m3]

/// A box of 4 x 4 cells, in 3D 4 x 4 x 4, 1 m wide and high, whose cells carry load or are melt.
template <class Element>
class MeltOf : public ::testing::Test {
protected:
  static constexpr int dim = Element::dimension;
  using Place = Vector<dim>;

  MeltOf() {
    forms_.update(mesh_);
    melt_.set_mesh(mesh_, true);
  }
  /// (element) whether its middle fulfils a condition.
  template <class Condition>
  std::vector<char> where(const Condition& holds) const {
    std::vector<char> marked;
    for (int e = 0; e < mesh_.elements(); ++e) {
      Place middle{};
      for (int i = 0; i < mesh_.nodes_per_element; ++i) {
        for (std::size_t d = 0; d < middle.size(); ++d)
          middle[d] += mesh_.point(mesh_.nodes_of(e)[i])[d] / mesh_.nodes_per_element;
      }
      marked.push_back(holds(middle.front(), middle.back()) ? 1 : 0);
    }
    return marked;
  }
  /// Resultant of the pressure along a coordinate axis.
  double pressed(const std::vector<char>& carries, double level, int axis) {
    std::vector<double> force(std::size_t(mesh_.nodes()) * dim, 0.0);
    const double down = melt_.press(forms_, carries, level, specific_weight, force);
    double sum = 0.0, upward = 0.0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      if (int(i % dim) == axis) sum += force[i];
      if (int(i % dim) == dim - 1) upward += force[i];
    }
    EXPECT_NEAR(down, -upward, 1e-9);
    return sum;
  }

  mesh::Mesh<dim> mesh_ = [] {
    if constexpr (dim == 2)
      return box<Element>({1.0, 1.0}, {4, 4});
    else
      return box<Element>({1.0, 1.0, 1.0}, {4, 4, 4});
  }();
  FormsOf<Element> forms_;
  Melt<dim> melt_;
};
using Families =
    ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::P1Tetrahedron, fem::Q1Hexahedron>;
TYPED_TEST_SUITE(MeltOf, Families);

TYPED_TEST(MeltOf, PressesWithItsDepth) {
  const auto lower_half = this->where([](double, double z) { return z < 0.5; });
  EXPECT_NEAR(this->pressed(lower_half, 1.5, TestFixture::dim - 1), -1.0 * specific_weight, 1e-8);
  EXPECT_NEAR(this->pressed(lower_half, 1.5, 0), 0.0, 1e-8);
}

/// A cup: its wall is pushed outwards by the pressure at half the depth.
TYPED_TEST(MeltOf, PressesOnWalls) {
  const auto cup = this->where([](double x, double z) { return x > 0.5 || z < 0.5; });
  EXPECT_NEAR(this->pressed(cup, 1.0, 0), 0.5 * 0.5 * 0.5 * specific_weight, 1e-8);
  EXPECT_NEAR(this->pressed(cup, 1.0, TestFixture::dim - 1), -0.5 * 0.5 * specific_weight, 1e-8);
}

/// Melt that the metal encloses stands to its own highest place, whatever the level.
TYPED_TEST(MeltOf, OfAClosedPoolStandsToItsOwnTop) {
  const auto carries =
      this->where([](double x, double z) { return x > 0.5 || z < 0.25 || z > 0.75; });
  EXPECT_NEAR(this->pressed(carries, 7.0, 0), 0.5 * 0.5 * 0.5 * specific_weight, 1e-8);
  EXPECT_NEAR(this->pressed(carries, 7.0, TestFixture::dim - 1), -0.5 * 0.5 * specific_weight,
              1e-8);
}

/// Coherent metal that floats, or is joined to the rest at an edge alone, carries no load; nor does
/// a shell at the side that does not reach the plane of symmetry.
TYPED_TEST(MeltOf, HoldsIslandsHingesAndShellsWithoutSupport) {
  const auto bottom = [](double, double z) { return z < 0.25; };
  const auto island = [&](double x, double z) { return bottom(x, z) || (x < 0.25 && z > 0.75); };
  const auto hinge = [&](double x, double z) {
    return (bottom(x, z) && x < 0.5) || (x > 0.5 && z > 0.25 && z < 0.5);
  };
  const auto side = [](double x, double) { return x > 0.75; };
  EXPECT_EQ(this->melt_.carrying(this->where(island)), this->where(bottom));
  EXPECT_EQ(this->melt_.carrying(this->where(hinge)),
            this->where([&](double x, double z) { return bottom(x, z) && x < 0.5; }));
  EXPECT_EQ(this->melt_.carrying(this->where(side)),
            std::vector<char>(std::size_t(this->mesh_.elements()), 0));
}

/// Melt follows metal that moves as a rigid body, and forgets where it was before.
TYPED_TEST(MeltOf, FollowsARigidMotion) {
  constexpr int dims = TestFixture::dim;
  const auto carries = this->where([](double, double z) { return z < 0.5; });
  std::vector<int> unknown;
  for (const int n : this->mesh_.element_node)
    for (int d = 0; d < dims; ++d) unknown.push_back(n * dims + d);
  const linalg::SparsityPattern pattern(this->mesh_.nodes() * dims, unknown,
                                        this->mesh_.nodes_per_element * dims);

  std::vector<char> held;
  std::vector<double> exact, moved;
  for (int n = 0; n < this->mesh_.nodes(); ++n) {
    const double x = this->mesh_.point(n)[0], z = this->mesh_.point(n)[dims - 1];
    for (int d = 0; d < dims; ++d) {
      const double turned = d == 0 ? -z : d == dims - 1 ? x : 0.0;
      exact.push_back(0.03 + 0.01 * turned);
      held.push_back(z <= 0.5 ? 1 : 0);
      moved.push_back(z <= 0.5 ? exact.back() : 0.1 * std::sin(double(n)));
    }
  }
  this->melt_.follow(this->forms_, carries, pattern, held, moved);
  for (std::size_t i = 0; i < moved.size(); ++i) EXPECT_NEAR(moved[i], exact[i], 1e-6);
}

/// A shell below melt: its weight and the pressure on it stand on the block. An island that the
/// shell reaches is born at its own temperature: it carries what follows, not what it cooled
/// before.
template <class Element>
class ShellBelowMelt : public ::testing::Test {};
TYPED_TEST_SUITE(ShellBelowMelt, Families);

TYPED_TEST(ShellBelowMelt, StandsOnTheBlockWithTheMeltOnIt) {
  SlabBench<TypeParam> bench(tight(strained));
  const auto shell = by_height([](double z) { return z < 0.05 ? 600.0 + 300.0 * z : 680.0; });
  bench.start(shell);
  bench.step(shell);
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_NEAR(checks.weight, 2360.0 * 9.81 * bench.bottom() * bench.depth, 0.05 * checks.weight)
      << "of a denser shell and the melt on it";
  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
}

TYPED_TEST(ShellBelowMelt, TakesInAnIslandWithoutItsPast) {
  Options free_side = tight(strained);
  free_side.confinement = false;
  SlabBench<TypeParam> bench(free_side);
  // By element, so that no cell is warmer or colder than its row.
  const auto rows = [&](double middle, double top) {
    std::vector<double> t;
    for (int e = 0; e < bench.slab.mesh().elements(); ++e) {
      const int row = e / bench.slab.elements_per_row();
      t.push_back(row == 0 ? 640.0 : row == 1 ? middle : top);
    }
    return t;
  };
  const std::vector<double> at_nodes(std::size_t(bench.slab.mesh().nodes()), 640.0);
  const auto step = [&](const std::vector<double>& before, const std::vector<double>& after) {
    constexpr double instant = 1e-12;  // [s] in which nothing creeps
    const auto outcome =
        bench.mechanics.step(bench.state, {after, at_nodes, instant, bench.slab.level(), before});
    EXPECT_TRUE(outcome.converged);
  };
  bench.mechanics.start(bench.state, rows(680.0, 680.0));
  step(rows(680.0, 680.0), rows(680.0, 640.0));
  EXPECT_GT(std::ranges::count(bench.state.solid, 1), std::ranges::count(bench.state.carries, 1));

  // The row between them freezes without cooling further; the 9 K of the island would be 200 MPa.
  step(rows(680.0, 640.0), rows(649.0 - 1e-9, 640.0));
  EXPECT_EQ(bench.state.carries, bench.state.solid);
  for (const auto& s : bench.state.deviator) EXPECT_LT(s.norm(), 1e6);
}

}  // namespace
}  // namespace dccast::mechanics
