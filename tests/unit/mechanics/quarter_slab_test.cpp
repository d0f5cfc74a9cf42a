#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/mechanics/slab_bench.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

const material::MechanicalProperties paper(material::testing::paper_card());

template <class Element>
class QuarterSlabOf : public ::testing::Test {};
TYPED_TEST_SUITE(QuarterSlabOf, SolidFamilies);

/// A block that nothing confines cools evenly: its contraction in closed form, up to what its
/// weight does, some kilopascals over 60 GPa.
TYPED_TEST(QuarterSlabOf, AnUnconfinedBlockContractsByItsThermalStretch) {
  Options options = tight(1e-9);
  options.confinement = false;
  SlabBench<TypeParam> bench(options);
  bench.start(uniform(600.0));
  bench.step(uniform(300.0));
  const double stretch = paper.thermal_stretch(300.0) - paper.thermal_stretch(600.0);
  for (int n = 0; n < bench.slab.mesh().nodes(); ++n) {
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(bench.moved(n)[d], stretch * bench.place(n)[d], 1e-4 * std::abs(stretch) * 0.5);
    }
  }
  EXPECT_LT(stretch, -0.005);
}

/// An oblique face that leans on the mould slides along it until the metal is cold.
TYPED_TEST(QuarterSlabOf, TheMouldHoldsAnObliqueFaceAlongItsNormal) {
  SlabBench<TypeParam> bench(tight(1e-9));
  bench.start(uniform(630.0));
  bench.step(by_height([](double z) { return z < 0.05 ? 610.0 : 640.0; }));
  double slid = 0.0, drawn_in = 0.0;
  int wide_faces = 0, leaning = 0;
  for (const auto& patch : bench.slab.mesh().patches) {
    if (patch.kind != mesh::PatchKind::side) continue;
    wide_faces += patch.normal[0] > 0.5 ? 0 : 1;
    for (int n : mesh::patch_nodes(patch)) {
      const Vector3 x = bench.place(n);
      const bool kink = std::abs(x[0] - 0.2) < 1e-9, plane = x[0] == 0.0;
      const bool corner = x[0] == 0.5 && x[1] > 0.199;
      if (x[2] < 0.05) {
        drawn_in = std::min(drawn_in, bench.outwards(n, patch));
        continue;
      }
      // At a kink it is the mean of two normals along which a node cannot move.
      EXPECT_LE(bench.outwards(n, patch), kink ? 5e-4 : 1e-15);
      leaning += std::abs(bench.outwards(n, patch)) < 1e-15 ? 1 : 0;
      if (!corner && !plane) slid = std::max(slid, std::abs(bench.moved(n)[0]));
      if (corner || plane) {
        EXPECT_LE(bench.moved(n)[1], 1e-15);
      }
    }
  }

  EXPECT_EQ(wide_faces, 2);
  EXPECT_GT(leaning, 4);
  EXPECT_GT(slid, 1e-5);
  EXPECT_LT(drawn_in, -1e-5);
}

/// Between steps displacements are stored along the coordinate axes. A displacement held by an
/// oblique side is exactly zero at the start of the next step: a step without any change needs no
/// iteration.
TYPED_TEST(QuarterSlabOf, AStepWithoutNewsTakesNoIterations) {
  SlabBench<TypeParam> bench(tight(1e-8));
  const auto mushy = by_height([](double z) { return z < 0.05 ? 610.0 : 630.0; });
  bench.start(uniform(640.0));
  bench.step(mushy, 1e-6);
  EXPECT_EQ(bench.step(mushy, 1e-15), 0);
}

/// A block that lies lower towards the corner: gaps count from it.
TYPED_TEST(QuarterSlabOf, AShapedBlockIsMetWhereItIs) {
  SlabBench<TypeParam> bench(tight(1e-9));
  std::vector<double> gap;
  for (int n : bench.mechanics.bottom_nodes()) {
    gap.push_back(2e-4 * (bench.place(n)[0] + bench.place(n)[1]));
  }
  EXPECT_THROW(bench.mechanics.set_initial_gap({1.0}), std::invalid_argument);

  bench.mechanics.set_initial_gap(gap);
  bench.state = bench.mechanics.initial_state();
  EXPECT_EQ(std::count(bench.state.contact.begin(), bench.state.contact.end(), 1), 1);

  bench.start(uniform(600.0));
  bench.step(uniform(599.0));
  bool below_zero = false;
  for (std::size_t i = 0; i < gap.size(); ++i) {
    const double up = bench.moved(bench.mechanics.bottom_nodes()[i])[2];
    EXPECT_DOUBLE_EQ(bench.mechanics.bottom_gap(bench.state, i), up + gap[i]);
    EXPECT_GE(up, -gap[i] - 1e-10);
    below_zero = below_zero || up < -1e-8;
  }
  EXPECT_TRUE(below_zero) << "a corner sinks into the hollow";
  EXPECT_NEAR(bench.mechanics.checks().bottom_reaction, bench.mechanics.checks().weight,
              1e-4 * bench.mechanics.checks().weight);
}

/// The four algorithms on a coarse slab that curls while its top is liquid. The steps are short, as
/// nbm needs them.
TEST(QuarterSlab, AllAlgorithmsAgree) {
  const auto run = [](Algorithm algorithm) {
    Options options = tight(1e-8);
    options.algorithm = algorithm;
    options.mould_length = 0.1;
    options.parameters.gamma_c = 5e9;
    SlabBench<fem::BendingHexahedron> bench(options);
    const auto field = [](double cooled) {
      return
          [=](double x, double, double z) { return 560.0 + 1000.0 * z - cooled * (1.0 + 2.0 * x); };
    };
    bench.start(field(0.0));
    for (int step = 1; step <= 2; ++step) bench.step(field(1.0 * step), 0.1);
    return bench.state.displacement;
  };
  const auto reference = run(Algorithm::newton);
  for (const Algorithm algorithm : {Algorithm::vnbm, Algorithm::sbm, Algorithm::nbm}) {
    EXPECT_LE(relative_difference(run(algorithm), reference), 1e-4) << name_of(algorithm);
  }
}

}  // namespace
}  // namespace dccast::mechanics
