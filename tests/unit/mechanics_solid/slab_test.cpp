#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/unit/mechanics_solid/quarter_slab.hpp"

namespace dccast::mechanics {
namespace {

using namespace testing;

const material::MechanicalProperties paper(material::testing::paper_card());

double cooled_from_below(const Vector3& x) {
  return 420.0 + 1500.0 * x[2];
}

template <class Element>
class QuarterSlabOf : public ::testing::Test {};
using Families = ::testing::Types<fem::P1Tetrahedron, fem::Q1Hexahedron, fem::BendingHexahedron>;
TYPED_TEST_SUITE(QuarterSlabOf, Families);

/// A block that nothing confines cools evenly: its contraction in closed form, up to what its
/// weight does, some kilopascals over 60 GPa.
TYPED_TEST(QuarterSlabOf, AnUnconfinedBlockContractsByItsThermalStretch) {
  Options options = slab_options();
  options.confinement = false;
  QuarterSlab<TypeParam> bench(options, true);
  bench.start([](const Vector3&) { return 600.0; });
  bench.step([](const Vector3&) { return 300.0; });
  const double stretch = paper.thermal_stretch(300.0) - paper.thermal_stretch(600.0);
  for (int n = 0; n < bench.slab.mesh().nodes(); ++n) {
    for (std::size_t d = 0; d < 3; ++d) {
      EXPECT_NEAR(bench.moved(n)[d], stretch * bench.place(n)[d], 1e-4 * std::abs(stretch) * 0.5);
    }
  }
  EXPECT_LT(stretch, -0.005);
}

/// Cold below, the slab curls; the block carries all of its weight and pulls nowhere.
TYPED_TEST(QuarterSlabOf, TheBlockCarriesTheWeightWhateverTheSlabDoes) {
  QuarterSlab<TypeParam> bench(slab_options(1e-10), true);
  bench.start([](const Vector3&) { return 600.0; });
  bench.step(cooled_from_below);
  const SlabChecks& checks = bench.mechanics.checks();

  EXPECT_NEAR(checks.bottom_reaction, checks.weight, 1e-5 * checks.weight);
  EXPECT_LE(checks.complementarity_error, 1e-6);
  EXPECT_LE(checks.equilibrium_residual, 1e-10);

  double area = 0.0, highest = 0.0;
  for (double a : bench.mechanics.bottom_area()) area += a;
  EXPECT_NEAR(area, 0.2 * (0.22 + 0.215) / 2 + 0.3 * (0.215 + 0.2) / 2, 1e-12);
  for (std::size_t i = 0; i < bench.mechanics.bottom_nodes().size(); ++i) {
    EXPECT_GE(bench.mechanics.bottom_gap(bench.state, i), -1e-10);
    highest = std::max(highest, bench.mechanics.bottom_gap(bench.state, i));
  }
  EXPECT_GT(highest, 1e-5);
  EXPECT_LT(checks.contact_length, area);
  EXPECT_GT(checks.contact_length, 0.0);
}

/// An oblique face that is held along its normal slides along the mould until the metal is solid.
TYPED_TEST(QuarterSlabOf, TheMouldHoldsAnObliqueFaceAlongItsNormal) {
  QuarterSlab<TypeParam> bench(slab_options(), true);
  const auto mushy = [](const Vector3&) { return 640.0; };
  bench.start(mushy);
  bench.step([](const Vector3& x) { return x[2] < 0.05 ? 610.0 : 630.0; });
  double slid = 0.0, drawn_in = 0.0;
  int wide_faces = 0;
  for (const auto& patch : bench.slab.mesh().patches) {
    if (patch.kind != mesh::PatchKind::side) continue;
    wide_faces += patch.normal[0] > 0.5 ? 0 : 1;
    for (int n : mesh::patch_nodes(patch)) {
      const Vector3 x = bench.place(n);
      const bool kink = std::abs(x[0] - 0.2) < 1e-9, plane = x[0] == 0.0;
      const bool corner = x[0] == 0.5 && x[1] > 0.199;
      if (x[2] < 0.05) {
        EXPECT_EQ(bench.state.released[std::size_t(n)], 1);
        drawn_in = std::min(drawn_in, bench.outwards(n, patch));
        continue;
      }
      EXPECT_EQ(bench.state.released[std::size_t(n)], 0);
      // At a kink the mean of two normals is held.
      EXPECT_NEAR(bench.outwards(n, patch), 0.0, kink ? 5e-4 : 1e-15);
      if (!corner && !plane) slid = std::max(slid, std::abs(bench.moved(n)[0]));
      if (corner || plane) {
        EXPECT_NEAR(bench.moved(n)[1], 0.0, 1e-15);
      }
    }
  }

  EXPECT_EQ(wide_faces, 2);
  EXPECT_GT(slid, 1e-5);
  EXPECT_LT(drawn_in, -1e-5);
}

/// Between steps displacements are stored along the coordinate axes. A displacement held by an
/// oblique side is exactly zero at the start of the next step: a step without any change needs no
/// iteration.
TYPED_TEST(QuarterSlabOf, AStepWithoutNewsTakesNoIterations) {
  QuarterSlab<TypeParam> bench(slab_options(1e-8), true);
  const auto mushy = [](const Vector3& x) { return x[2] < 0.05 ? 610.0 : 630.0; };
  bench.start([](const Vector3&) { return 640.0; });
  bench.step(mushy, 1e-6);
  EXPECT_EQ(bench.step(mushy, 1e-15), 0);
}

/// Springs in place of the exact condition: the stiffer, the nearer.
TYPED_TEST(QuarterSlabOf, ConfinementByPenaltyTendsToTheExactOne) {
  const auto mushy = [](const Vector3&) { return 645.0; };
  const auto displacement = [&](Confinement by, double stiffness) {
    Options options = slab_options();
    options.confinement_by = by;
    options.confinement_stiffness = stiffness;
    QuarterSlab<TypeParam> bench(options, true);
    bench.start(mushy);
    bench.step([](const Vector3&) { return 640.0; });
    return bench.state.displacement;
  };
  const auto exact = displacement(Confinement::exact, 0.0);
  const auto difference = [&](double stiffness) {
    const auto u = displacement(Confinement::penalty, stiffness);
    double sum = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) sum += (u[i] - exact[i]) * (u[i] - exact[i]);
    return std::sqrt(sum);
  };
  EXPECT_NEAR(difference(1e14) / difference(1e15), 10.0, 1.0);
}

/// A block that lies lower towards the corner: gaps count from it.
TYPED_TEST(QuarterSlabOf, AShapedBlockIsMetWhereItIs) {
  QuarterSlab<TypeParam> bench(slab_options());
  std::vector<double> gap;
  for (int n : bench.mechanics.bottom_nodes()) {
    gap.push_back(2e-4 * (bench.place(n)[0] + bench.place(n)[1]));
  }
  EXPECT_THROW(bench.mechanics.set_initial_gap({1.0}), std::invalid_argument);

  bench.mechanics.set_initial_gap(gap);
  bench.state = bench.mechanics.initial_state();
  EXPECT_EQ(std::count(bench.state.contact.begin(), bench.state.contact.end(), 1), 1);

  bench.start([](const Vector3&) { return 600.0; });
  bench.step([](const Vector3&) { return 599.0; });
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

/// A released slab that warms up again is stopped by the mould wall within the length of the mould,
/// and leaves the wall when it contracts.
TYPED_TEST(QuarterSlabOf, AReleasedSideCannotPassTheWall) {
  Options options = slab_options();
  options.mould_wall = true;
  options.mould_length = 0.07;  // of 0.12 m of metal
  QuarterSlab<TypeParam> bench(options, true);
  bench.start([](const Vector3&) { return 500.0; });
  bench.step([](const Vector3&) { return 499.0; });
  EXPECT_EQ(bench.mechanics.checks().wall_reaction, 0.0);

  const auto most_outwards = [&](bool within) {
    double most = -1.0;
    for (const auto& patch : bench.slab.mesh().patches) {
      if (patch.kind != mesh::PatchKind::side) continue;
      for (int n : mesh::patch_nodes(patch)) {
        if ((bench.place(n)[2] > 0.05) != within || std::abs(bench.place(n)[0] - 0.2) < 1e-9)
          continue;
        most = std::max(most, bench.outwards(n, patch));
      }
    }
    return most;
  };
  EXPECT_LT(most_outwards(true), -1e-6);

  bench.step([](const Vector3&) { return 520.0; });
  EXPECT_LE(most_outwards(true), 1e-9);
  EXPECT_GT(most_outwards(true), -1e-9);
  EXPECT_GT(most_outwards(false), 1e-6) << "below the mould nothing stands in its way";
  EXPECT_GT(bench.mechanics.checks().wall_reaction, 1.0);
  EXPECT_EQ(bench.state.contact.size(), bench.mechanics.bottom_nodes().size());

  bench.step([](const Vector3&) { return 495.0; });
  EXPECT_LT(most_outwards(true), -1e-6);
}

/// Growth keeps elastic strain, and new nodes stand at the mould.
TYPED_TEST(QuarterSlabOf, GrowthKeepsElasticStrain) {
  QuarterSlab<TypeParam> bench(slab_options(), true);
  bench.start([](const Vector3&) { return 600.0; });
  bench.step(cooled_from_below);
  const int old_nodes = bench.slab.mesh().nodes();
  for (double level : {0.122, 0.16}) {
    const auto elastic = [&] {
      FormsOf<TypeParam> forms;
      forms.update(bench.slab.mesh());
      std::vector<SymmetricTensor<3>> all;
      for (std::size_t i = 0; i < bench.state.inelastic.size(); ++i) {
        all.push_back(
            forms.strain(i / forms.points(), i % forms.points(), bench.state.displacement));
        all.back().add(-1.0, bench.state.inelastic[i]);
      }
      return all;
    };
    const auto before = elastic();
    const int first_moved = bench.slab.mesh().elements() - bench.slab.elements_per_row();
    bench.slab.grow_to(level);
    bench.mechanics.follow_growth(bench.state, bench.slab.mesh(), bench.slab.nodes_per_row(),
                                  first_moved);
    const auto after = elastic();
    for (std::size_t i = 0; i < after.size(); ++i) {
      auto d = after[i];
      if (i < before.size()) d.add(-1.0, before[i]);
      EXPECT_LE(d.norm(), 1e-15 + 1e-10 * after[i].norm()) << "point " << i;
    }
  }
  const auto* side = bench.slab.mesh().find("side_y_2");
  ASSERT_NE(side, nullptr);

  for (int n : mesh::patch_nodes(*side)) {
    if (n < old_nodes || std::abs(bench.place(n)[0] - 0.2) < 1e-9) continue;
    EXPECT_NEAR(bench.outwards(n, *side), 0.0, 1e-17);
  }
  bench.step([](const Vector3& x) { return x[2] < 0.1 ? cooled_from_below(x) : 680.0; });
}

/// The four algorithms on a coarse slab that curls while its top is liquid. The steps are short, as
/// nbm needs them.
TEST(QuarterSlab, AllAlgorithmsAgree) {
  const auto run = [](Algorithm algorithm) {
    Options options = slab_options(1e-8);
    options.algorithm = algorithm;
    options.mould_wall = true;
    options.mould_length = 0.1;
    options.parameters.gamma_c = 5e9;
    QuarterSlab<fem::BendingHexahedron> bench(options, true);
    const auto field = [](double cooled) {
      return [=](const Vector3& x) { return 560.0 + 1000.0 * x[2] - cooled * (1.0 + 2.0 * x[0]); };
    };
    bench.start(field(0.0));
    for (int step = 1; step <= 2; ++step) bench.step(field(1.0 * step), 0.1);
    return bench.state.displacement;
  };
  const auto reference = run(Algorithm::newton);
  for (const Algorithm algorithm : {Algorithm::vnbm, Algorithm::sbm, Algorithm::nbm}) {
    const auto u = run(algorithm);
    double sum = 0.0, scale = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) {
      sum += (u[i] - reference[i]) * (u[i] - reference[i]), scale += reference[i] * reference[i];
    }
    EXPECT_LE(std::sqrt(sum / scale), 1e-4) << int(algorithm);
  }
}

}  // namespace
}  // namespace dccast::mechanics
