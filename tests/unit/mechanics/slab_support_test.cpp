#include <gmock/gmock.h>

#include <map>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;
using mesh::PatchKind;

/// Cold at the bottom: the ends curl upwards or downwards, in any case away from a straight bottom.
const auto cooled_from_below = by_height([](double z) { return 420.0 + 1500.0 * z; });
const auto cooled_from_above = by_height([](double z) { return 570.0 - 1500.0 * z; });

template <class Element>
class SupportOf : public ::testing::Test {
protected:
  using Field = typename SlabBench<Element>::Field;

  SlabBench<Element> bench_{tight(strained)};
};
using Families = ::testing::Types<fem::P1Triangle, fem::Q1Quadrilateral, fem::AxisymmetricQ1,
                                  fem::BendingQuadrilateral, fem::AxisymmetricBending,
                                  fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(SupportOf, Families);

TYPED_TEST(SupportOf, TheBlockCarriesTheWeightWhateverTheSlabDoes) {
  auto& bench = this->bench_;
  double area = 0.0;
  for (double a : bench.mechanics.bottom_area()) area += a;
  EXPECT_NEAR(area, bench.bottom(), 1e-12);

  bench.start(uniform(600.0));
  for (const typename TestFixture::Field& field :
       {typename TestFixture::Field(cooled_from_below),
        typename TestFixture::Field(cooled_from_above)}) {
    bench.step(field);
    const SlabChecks& checks = bench.mechanics.checks();
    EXPECT_GT(checks.weight, 2360.0 * 9.81 * area * bench.depth);
    EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
    EXPECT_LE(checks.complementarity_error, 1e-6);
    EXPECT_LE(checks.equilibrium_residual, 1e-11);
    EXPECT_LT(checks.contact_length, bench.solid ? area : bench.width)
        << "some of the bottom has left the block";
    EXPECT_GT(checks.contact_length, 0.0);

    double highest = 0.0;
    for (std::size_t i = 0; i < bench.mechanics.bottom_nodes().size(); ++i) {
      const double gap = bench.mechanics.bottom_gap(bench.state, i);
      EXPECT_DOUBLE_EQ(gap, bench.upwards(bench.mechanics.bottom_nodes()[i]));
      EXPECT_GE(gap, -1e-10);
      highest = std::max(highest, gap);
    }
    EXPECT_GT(highest, 1e-5);
  }
}

TYPED_TEST(SupportOf, WithoutContactTheBottomIsHeld) {
  Options options = tight(strained);
  options.contact = false;
  SlabBench<TypeParam> bench(options);
  bench.start(uniform(600.0));
  bench.step(cooled_from_below);
  for (int n : bench.mechanics.bottom_nodes()) EXPECT_EQ(bench.upwards(n), 0.0);
  const SlabChecks& checks = bench.mechanics.checks();

  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-5 * checks.weight);
  EXPECT_NEAR(checks.contact_length, bench.solid ? bench.bottom() : bench.width, 1e-14);
  // It pulls somewhere: the same slab on contact lifts there.
  EXPECT_LT(*std::min_element(bench.state.reaction.begin(), bench.state.reaction.end()), -1.0);
}

/// Hot metal leans on the mould where it is: it can leave it, but not move outwards. Cold metal,
/// and metal below the mould, is free.
TYPED_TEST(SupportOf, HotMetalCannotMoveOutwards) {
  Options options = tight(1e-10);
  options.mould_length = SlabBench<TypeParam>::depth - 0.05;
  SlabBench<TypeParam> bench(options);
  const auto outwards = [&] {
    std::map<int, double> place;
    bench.for_each_node(PatchKind::side,
                        [&](int n, const auto& side) { place[n] = bench.outwards(n, side); });
    return place;
  };
  bench.start(uniform(600.0));
  bench.step(uniform(590.0));
  const auto cold = outwards();
  for (const auto& [n, place] : cold) EXPECT_LT(place, -1e-6) << "it contracts";
  EXPECT_EQ(bench.mechanics.checks().wall_reaction, 0.0);

  bench.step(uniform(630.0));
  int leaning = 0;
  for (const auto& [n, place] : outwards()) {
    if (bench.place(n).back() >= 0.05) {
      EXPECT_LE(place, cold.at(n) + 1e-10);
      leaning += place > cold.at(n) - 1e-10 ? 1 : 0;
    } else {
      EXPECT_GT(place, cold.at(n)) << "below the mould nothing stands in its way";
    }
  }
  EXPECT_GT(leaning, 0);
  EXPECT_GT(bench.mechanics.checks().wall_reaction, 1.0);
  EXPECT_EQ(bench.state.contact.size(), bench.mechanics.bottom_nodes().size());

  bench.step(uniform(625.0));
  for (const auto& [n, place] : outwards()) {
    if (bench.place(n).back() < 0.05) continue;
    EXPECT_LT(place, cold.at(n) + 1e-10) << "hot metal that contracts leaves the mould";
  }
  bench.step(uniform(610.0));
  EXPECT_EQ(bench.mechanics.checks().wall_reaction, 0.0);
}

TYPED_TEST(SupportOf, WithoutConfinementTheSideIsFree) {
  Options options = tight(hydrostatic);
  options.confinement = false;
  SlabBench<TypeParam> bench(options);
  bench.start(uniform(640.0));
  bench.step(uniform(630.0));
  bench.for_each_node(PatchKind::side,
                      [&](int n, const auto& side) { EXPECT_LT(bench.outwards(n, side), -1e-5); });
  bench.for_each_node(PatchKind::symmetry,
                      [&](int n, const auto& plane) { EXPECT_EQ(bench.outwards(n, plane), 0.0); });
}

/// Springs instead of the exact support: the stiffer they are, the closer the result.
TYPED_TEST(SupportOf, ConfinementByPenaltyTendsToTheExactOne) {
  const auto displacement = [](Confinement by, double stiffness) {
    Options options = tight(1e-10);
    options.confinement_by = by;
    options.confinement_stiffness = stiffness;
    SlabBench<TypeParam> bench(options);
    bench.start(uniform(640.0));
    bench.step(uniform(645.0));
    return bench.state.displacement;
  };
  const auto exact = displacement(Confinement::exact, 0.0);
  const auto differences = [&](double stiffness) {
    auto u = displacement(Confinement::penalty, stiffness);
    for (std::size_t i = 0; i < u.size(); ++i) u[i] -= exact[i];
    return u;
  };
  const auto norm = [](const std::vector<double>& u) {
    return Eigen::Map<const Eigen::VectorXd>(u.data(), long(u.size())).norm();
  };
  const auto soft = differences(1e14);
  EXPECT_LT(largest_of(soft), 1e-6);
  EXPECT_NEAR(norm(soft) / norm(differences(1e15)), 10.0, 0.5);
}

/// Small and large rises of the metal level: moved cells keep their elastic strain, new ones have
/// none, and new nodes stand at the mould.
TYPED_TEST(SupportOf, GrowthKeepsElasticStrain) {
  auto& bench = this->bench_;
  bench.start(uniform(600.0));
  bench.step(cooled_from_below);
  for (double rise : {0.0002, 0.008, 0.05}) {
    const auto elastic = bench.elastic_strain();
    const auto& mesh = bench.slab.mesh();
    const int old_nodes = mesh.nodes(), stride = bench.slab.nodes_per_row();
    const int first_moved = mesh.elements() - bench.slab.elements_per_row();
    bench.slab.grow_to(bench.depth + rise);
    bench.mechanics.follow_growth(bench.state, mesh, stride, first_moved);

    const auto now = bench.elastic_strain();
    ASSERT_EQ(now.size(), std::size_t(mesh.elements()) * TypeParam::points);
    for (std::size_t i = 0; i < now.size(); ++i) {
      auto d = now[i];
      if (i < elastic.size()) d.add(-1.0, elastic[i]);
      EXPECT_LE(d.norm(), 1e-15 + (bench.solid ? 1e-10 : 1e-12) * now[i].norm()) << "point " << i;
    }

    std::vector<char> at_mould(std::size_t(mesh.nodes()), 0);
    for (int n : mesh::patch_nodes(mesh, PatchKind::side)) at_mould[std::size_t(n)] = 1;
    for (int n = old_nodes; n < mesh.nodes(); ++n) {
      EXPECT_EQ(bench.upwards(n), bench.upwards(n - stride));
      if (at_mould[std::size_t(n)] == 0) {
        EXPECT_EQ(bench.moved(n), bench.moved(n - stride));
      }
    }
    bench.for_each_node(PatchKind::side, [&](int n, const auto& side) {
      if (n < old_nodes) return;
      EXPECT_NEAR(bench.outwards(n, side), 0.0, bench.solid ? 1e-17 : 0.0);
    });

    bench.step(by_height([](double z) { return z < 0.1 ? cooled_from_below(z) : 680.0; }));
    EXPECT_NEAR(bench.mechanics.checks().bottom_reaction, bench.mechanics.checks().weight,
                1e-6 * bench.mechanics.checks().weight);
  }
}

/// The paper's weak material, eq. (38): far from hydrostatic, but in balance with the weight.
TYPED_TEST(SupportOf, TheWeakLiquidIsInBalanceToo) {
  Options options = tight(hydrostatic);
  options.liquid = Liquid::weak;
  SlabBench<TypeParam> bench(options);
  const auto shell = by_height([](double z) { return z < 0.05 ? 600.0 : 680.0; });
  bench.start(shell);
  bench.step(shell);
  const SlabChecks& checks = bench.mechanics.checks();
  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-6 * checks.weight);
}

}  // namespace
}  // namespace dccast::mechanics
