#include <gmock/gmock.h>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

double warm(double, double) {
  return 600.0;
}
/// Cold at the bottom: the ends curl upwards or downwards, in any case away from a straight bottom.
double cooled_from_below(double, double y) {
  return 420.0 + 1500.0 * y;
}
double cooled_from_above(double, double y) {
  return 570.0 - 1500.0 * y;
}

template <class Element>
class SupportOf : public ::testing::Test {
protected:
  SlabBench<Element> bench_{balanced_to(strained)};

  double highest_bottom() const {
    double highest = -1.0;
    for (int n : bench_.mechanics.bottom_nodes()) highest = std::max(highest, bench_.upwards(n));
    return highest;
  }
};
using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::AxisymmetricQ1,
                                  fem::BendingQuadrilateral, fem::AxisymmetricBending>;
TYPED_TEST_SUITE(SupportOf, Families);

TYPED_TEST(SupportOf, TheBlockCarriesTheWeightWhateverTheSlabDoes) {
  auto& bench = this->bench_;
  bench.start(warm);
  for (auto field : {cooled_from_below, cooled_from_above}) {
    bench.step(field);
    const SlabChecks& checks = bench.mechanics.checks();
    EXPECT_GT(checks.weight, 2360.0 * 9.81 * bench.face * bench.depth);
    EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
    EXPECT_LE(checks.complementarity_error, 1e-6);
    EXPECT_LE(checks.equilibrium_residual, 1e-11);
    EXPECT_LT(checks.contact_length, 0.28) << "some of the bottom has left the block";
    EXPECT_GT(checks.contact_length, 0.0);
    for (int n : bench.mechanics.bottom_nodes()) EXPECT_GE(bench.upwards(n), -1e-10);
  }
}

TYPED_TEST(SupportOf, WithoutContactTheBottomIsHeld) {
  Options options = balanced_to(strained);
  options.contact = false;
  SlabBench<TypeParam> bench(options);
  bench.start(warm);
  bench.step(cooled_from_below);
  for (int n : bench.mechanics.bottom_nodes()) EXPECT_EQ(bench.upwards(n), 0.0);
  const SlabChecks& checks = bench.mechanics.checks();

  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-5 * checks.weight);
  EXPECT_NEAR(checks.contact_length, 0.28, 1e-14);
  // It pulls somewhere: the same slab on contact lifts there.
  EXPECT_LT(*std::min_element(bench.state.reaction.begin(), bench.state.reaction.end()), -1.0);

  this->bench_.start(warm);
  this->bench_.step(cooled_from_below);
  EXPECT_GT(this->highest_bottom(), 1e-5);
}

TYPED_TEST(SupportOf, TheMouldLetsGoOnceAndForAll) {
  SlabBench<TypeParam> bench;
  const auto mushy = [](double, double) { return 630.0; };
  bench.start(mushy);
  bench.step(mushy);
  const auto side = mesh::patch_nodes(bench.slab.mesh(), mesh::PatchKind::side);
  for (int n : side) {
    EXPECT_EQ(bench.state.released[std::size_t(n)], 0);
    EXPECT_EQ(bench.across(n), 0.0);
  }

  // The lower half passes the solidus, then warms up again.
  const auto lower_half = [&](int n) { return bench.slab.mesh().point(n)[1] < 0.05; };
  bench.step([](double, double y) { return y < 0.05 ? 610.0 : 630.0; });
  for (int repeat = 0; repeat < 2; ++repeat) {
    for (int n : side) {
      EXPECT_EQ(bench.state.released[std::size_t(n)] != 0, lower_half(n)) << n;
      if (lower_half(n)) {
        EXPECT_LT(bench.across(n), -1e-6) << "it contracts";
      } else {
        EXPECT_EQ(bench.across(n), 0.0);
      }
    }
    bench.step(mushy);
  }
}

TYPED_TEST(SupportOf, WithoutConfinementTheSideIsFree) {
  Options options = balanced_to(hydrostatic);
  options.confinement = false;
  SlabBench<TypeParam> bench(options);
  const auto mushy = [](double, double) { return 640.0; };
  bench.start(mushy);
  bench.step([](double, double) { return 630.0; });
  for (int n : mesh::patch_nodes(bench.slab.mesh(), mesh::PatchKind::side))
    EXPECT_LT(bench.across(n), -1e-5);
  for (int n : mesh::patch_nodes(bench.slab.mesh(), mesh::PatchKind::symmetry)) {
    EXPECT_EQ(bench.across(n), 0.0);
  }
}

/// A released slab that warms up again is stopped by the mould wall within the length of the mould,
/// and leaves the wall when it contracts.
TYPED_TEST(SupportOf, AReleasedSideCannotPassTheWall) {
  Options options = balanced_to(1e-10);
  options.mould_wall = true;
  options.mould_length = 0.05;  // of 0.1 m of metal
  SlabBench<TypeParam> bench(options);
  const auto side = mesh::patch_nodes(bench.slab.mesh(), mesh::PatchKind::side);
  const auto most_outwards = [&](bool within) {
    double most = -1.0;
    for (int n : side) {
      if ((bench.slab.mesh().point(n)[1] >= 0.05) == within) most = std::max(most, bench.across(n));
    }
    return most;
  };
  bench.start(warm);
  bench.step([](double, double) { return 599.0; });

  EXPECT_LT(most_outwards(true), -1e-6);
  EXPECT_EQ(bench.mechanics.checks().wall_reaction, 0.0);

  bench.step([](double, double) { return 618.0; });
  EXPECT_NEAR(most_outwards(true), 0.0, 1e-10);
  EXPECT_GT(most_outwards(false), 1e-6) << "below the mould nothing stands in its way";
  EXPECT_GT(bench.mechanics.checks().wall_reaction, 1.0);
  EXPECT_EQ(bench.state.contact.size(), bench.mechanics.bottom_nodes().size());

  bench.step([](double, double) { return 590.0; });
  EXPECT_LT(most_outwards(true), -1e-6);
  EXPECT_EQ(bench.mechanics.checks().wall_reaction, 0.0);
}

/// Springs instead of the exact support: the stiffer they are, the closer the result.
TYPED_TEST(SupportOf, ConfinementByPenaltyTendsToTheExactOne) {
  const auto at_the_side = [](double stiffness) {
    Options options = balanced_to(1e-10);
    options.confinement_by = Confinement::penalty;
    options.confinement_stiffness = stiffness;
    SlabBench<TypeParam> bench(options);
    bench.start([](double, double) { return 645.0; });
    bench.step([](double, double) { return 640.0; });
    double most = 0.0;
    for (int n : mesh::patch_nodes(bench.slab.mesh(), mesh::PatchKind::side)) {
      most = std::max(most, std::abs(bench.across(n)));
    }
    return most;
  };
  EXPECT_LT(at_the_side(1e14), 1e-6);
  EXPECT_NEAR(at_the_side(1e14) / at_the_side(1e15), 10.0, 0.5);
}

/// Small and large rises of the metal level: moved cells keep their elastic strain, new ones have
/// none.
TYPED_TEST(SupportOf, GrowthKeepsElasticStrain) {
  auto& bench = this->bench_;
  bench.start(warm);
  bench.step(cooled_from_below);
  for (double level : {0.1002, 0.108, 0.15}) {
    const auto elastic = bench.elastic_strain();
    const mesh::Mesh2D& mesh = bench.slab.mesh();
    const int per_row = mesh.elements() / bench.slab.rows();
    const int first_moved = mesh.elements() - per_row;
    const int old_nodes = mesh.nodes(), stride = bench.slab.nodes_per_row();
    bench.slab.grow_to(level);
    bench.mechanics.follow_growth(bench.state, bench.slab.mesh(), stride, first_moved);
    const auto now = bench.elastic_strain();
    ASSERT_EQ(now.size(), std::size_t(bench.slab.mesh().elements()) * TypeParam::points);
    for (std::size_t i = 0; i < now.size(); ++i) {
      auto d = now[i];
      if (i < elastic.size()) d.add(-1.0, elastic[i]);
      EXPECT_LE(d.norm(), 1e-15 + 1e-12 * now[i].norm()) << "point " << i;
    }
    for (int n = old_nodes; n < bench.slab.mesh().nodes(); ++n) {
      const bool at_mould = n % stride == stride - 1;
      EXPECT_EQ(bench.across(n), at_mould ? 0.0 : bench.across(n - stride));
      EXPECT_EQ(bench.upwards(n), bench.upwards(n - stride));
      EXPECT_EQ(bench.state.released[std::size_t(n)], 0);
    }
    bench.step([](double x, double y) { return y < 0.1 ? cooled_from_below(x, y) : 680.0; });
    EXPECT_NEAR(bench.mechanics.checks().bottom_reaction, bench.mechanics.checks().weight,
                1e-6 * bench.mechanics.checks().weight);
  }
}

/// The paper's weak material, eq. (38): far from hydrostatic, but in balance with the weight.
TYPED_TEST(SupportOf, TheWeakLiquidIsInBalanceToo) {
  Options options = balanced_to(hydrostatic);
  options.liquid = Liquid::weak;
  SlabBench<TypeParam> bench(options);
  const auto shell = [](double, double y) { return y < 0.05 ? 600.0 : 680.0; };
  bench.start(shell);
  bench.step(shell);
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
  EXPECT_GT(checks.liquid_pressure_error, 0.0);
}

}  // namespace
}  // namespace dccast::mechanics
