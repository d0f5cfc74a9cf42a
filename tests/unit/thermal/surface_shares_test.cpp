#include "core/thermal/heat_forms.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

using testing::casting_cooling;
using testing::casting_section;

std::map<int, double> length_by_law(const std::vector<SideShare>& shares) {
  std::map<int, double> length;
  for (const SideShare& share : shares) length[share.law] += share.weight;
  return length;
}

std::vector<SideShare> shares_of(const CoolingSpec& cooling, double level, bool water_runs,
                                 mesh::SectionKind kind = mesh::SectionKind::plane_strain) {
  const mesh::SlabMesh2D slab(casting_section(mesh::ElementKind::p1));
  std::vector<SideShare> shares;
  make_heat_forms(slab.mesh(), kind)->divide_side(cooling, {level, {water_runs}, {}}, shares);
  return shares;
}

TEST(SideShares, EveryLawGetsItsExactLength) {
  auto length = length_by_law(shares_of(casting_cooling(), 0.10, true));
  EXPECT_NEAR(length[0], 0.030, 1e-15);
  EXPECT_NEAR(length[1], 0.035, 1e-15);
  EXPECT_NEAR(length[law_water], 0.035, 1e-15);
  EXPECT_EQ(length.count(law_dry), 0U);
}

TEST(SideShares, WithoutWaterTheRestIsDry) {
  auto length = length_by_law(shares_of(casting_cooling(), 0.10, false));
  EXPECT_NEAR(length[law_dry], 0.035, 1e-15);
  EXPECT_EQ(length.count(law_water), 0U);
}

TEST(SideShares, AxisymmetricOnesAreTimesTheRadius) {
  auto length =
      length_by_law(shares_of(casting_cooling(), 0.10, true, mesh::SectionKind::axisymmetric));
  EXPECT_NEAR(length[0], 0.030 * 0.28, 1e-15);
  EXPECT_NEAR(length[law_water], 0.035 * 0.28, 1e-15);
}

TEST(SideShares, FirstMomentIsExact) {
  // The weights of a law, times the height of the nodes, give the integral of the height.
  const mesh::SlabMesh2D slab(casting_section(mesh::ElementKind::q1));
  std::vector<SideShare> shares;
  make_heat_forms(slab.mesh(), mesh::SectionKind::plane_strain)
      ->divide_side(casting_cooling(), {0.10, {true}, {}}, shares);
  std::map<int, double> moment;
  for (const SideShare& share : shares) {
    moment[share.law] += share.weight * slab.mesh().point(share.node)[1];
  }
  const auto exact = [](double low, double high) { return 0.5 * (high * high - low * low); };

  EXPECT_NEAR(moment[law_water], exact(0.0, 0.035), 1e-16);
  EXPECT_NEAR(moment[1], exact(0.035, 0.07), 1e-16);
  EXPECT_NEAR(moment[0], exact(0.07, 0.1), 1e-16);
}

TEST(SideShares, AreContinuousInEveryEdge) {
  // The edge passes a node of the side: nothing may jump.
  const mesh::SlabMesh2D slab(casting_section(mesh::ElementKind::p1));
  const double node_distance = 0.10 - slab.row_heights()[9];
  const auto weight_of_node = [&](double water_line) {
    CoolingSpec cooling = casting_cooling();
    cooling.water.from = cooling.zones[1].to = water_line;
    std::vector<double> water(std::size_t(slab.mesh().nodes()), 0.0);
    std::vector<SideShare> shares;
    make_heat_forms(slab.mesh(), mesh::SectionKind::plane_strain)
        ->divide_side(cooling, {0.10, {true}, {}}, shares);
    for (const SideShare& share : shares) {
      if (share.law == law_water) water[std::size_t(share.node)] += share.weight;
    }
    return water;
  };
  const auto below = weight_of_node(node_distance - 1e-12),
             above = weight_of_node(node_distance + 1e-12);
  for (std::size_t i = 0; i < below.size(); ++i) EXPECT_NEAR(below[i], above[i], 3e-12);
}

TEST(SideShares, TablesAgainstDistanceAreIntegratedExactly) {
  CoolingSpec cooling = casting_cooling();
  cooling.zones[0].solid_coefficient = {Abscissa::distance, {0.0, 0.011, 0.03}, {400, 150, 10}};
  double sum = 0.0;
  for (const SideShare& share : shares_of(cooling, 0.10, true)) {
    if (share.law == 0) sum += share.weight * cooling.zones[0].solid_coefficient(share.distance);
  }
  EXPECT_NEAR(sum, cooling.zones[0].solid_coefficient.integral(0.0, 0.03), 1e-13);
}

TEST(BottomWeights, SumToTheSection) {
  const mesh::SlabMesh2D slab(casting_section(mesh::ElementKind::q1));
  const auto sum = [&](mesh::SectionKind kind) {
    const auto forms = make_heat_forms(slab.mesh(), kind);
    forms->update();
    return std::accumulate(forms->bottom_weight().begin(), forms->bottom_weight().end(), 0.0);
  };
  EXPECT_NEAR(sum(mesh::SectionKind::plane_strain), 0.28, 1e-15);
  EXPECT_NEAR(sum(mesh::SectionKind::axisymmetric), 0.5 * 0.28 * 0.28, 1e-16);
}

}  // namespace
}  // namespace dccast::thermal
