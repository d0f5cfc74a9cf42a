#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/support/print_kinds.hpp"
#include "tests/verification/mechanics/exact_checks.hpp"
#include "tests/verification/mechanics/t1.hpp"

namespace dccast::verification {
namespace {

using mechanics::Algorithm;
using mesh::ElementKind;

Figures figures_of(const Result& result) {
  const auto* failed = std::get_if<Failed>(&result);
  EXPECT_EQ(failed, nullptr) << failed->why;
  return failed == nullptr ? std::get<Figures>(result) : Figures{};
}

class MechanicsOn : public ::testing::TestWithParam<ElementKind> {};

TEST_P(MechanicsOn, PressedSolidConvergesAtSecondAndFirstOrder) {
  const auto run = [](int factor) {
    T1Run t1;
    t1.columns = 20 * factor, t1.rows = 24 * factor, t1.element = GetParam();
    return run_t1(t1).whole;
  };
  const PartErrors coarse = run(1), fine = run(2);
  EXPECT_NEAR(std::log2(coarse.displacement / fine.displacement), 2.0, 0.15);
  EXPECT_NEAR(std::log2(coarse.stress / fine.stress), 1.0, 0.1);
}

TEST_P(MechanicsOn, BowedStripConverges) {
  const auto run = [](int cells) {
    TestRun strip;
    strip.cells = cells, strip.element = GetParam();
    return figures_of(run_bowed_strip(strip));
  };
  const Figures coarse = run(16), fine = run(32);
  EXPECT_GT(std::log2(coarse.displacement_error / fine.displacement_error), 1.8);
  EXPECT_GT(std::log2(coarse.stress_error / fine.stress_error), 0.9);
}

TEST_P(MechanicsOn, RotationAndLinearFieldsPassThePatchTest) {
  TestRun run;
  run.element = GetParam();
  const Figures figures = figures_of(run_patch(run));
  EXPECT_LT(figures.displacement_error, 1e-12);
  EXPECT_LT(figures.stress_error, 1e-11);
}

TEST_P(MechanicsOn, ContactWithACylinderConvergesToHertz) {
  const auto run = [](int cells) {
    TestRun block;
    block.cells = cells, block.element = GetParam();
    return figures_of(run_hertz(block));
  };
  const Figures coarse = run(16), fine = run(64);
  for (const Figures& figures : {coarse, fine}) {
    EXPECT_LE(figures.more.at("half_width_error_in_cells"), 1.0);
    EXPECT_LE(figures.more.at("complementarity_error"), 1e-10);
    EXPECT_LE(figures.more.at("load_error"), 1e-8);
    EXPECT_LE(figures.more.at("finite_body_error"), 1e-4);
  }
  EXPECT_GT(std::log2(coarse.stress_error / fine.stress_error) / 2, 0.85);
  EXPECT_GT(std::log2(coarse.more.at("pressure_error") / fine.more.at("pressure_error")) / 2, 0.6);
}

TEST_P(MechanicsOn, ContactWithACylinderOpensAsItClosed) {
  TestRun run;
  run.cells = 32, run.element = GetParam();
  const Figures figures = figures_of(run_hertz_cycle(run));
  EXPECT_EQ(figures.steps, 7);
  EXPECT_LE(figures.more.at("half_width_error_in_cells"), 1.0);
  EXPECT_LE(figures.more.at("complementarity_error"), 1e-10);
  EXPECT_LE(figures.more.at("load_error"), 1e-8);
  EXPECT_LE(figures.more.at("difference_after_cycle"), 1e-10);
}

TEST_P(MechanicsOn, AxisymmetricUniformStrainPassesThePatchTest) {
  TestRun run;
  run.element = GetParam();
  const Figures figures = figures_of(run_axisymmetric_patch(run));
  EXPECT_LT(figures.displacement_error, 1e-12);
  EXPECT_LT(figures.stress_error, 1e-11);
}

TEST_P(MechanicsOn, PressedTubeConvergesAtSecondAndFirstOrder) {
  TestRun run;
  run.element = GetParam();
  const Figures figures = figures_of(run_tube(run));
  EXPECT_NEAR(figures.more.at("order_displacement"), 2.0, 0.1);
  EXPECT_NEAR(figures.more.at("order_stress"), 1.0, 0.05);
}

TEST(Tube, QuadrilateralsDoNotLockWhereTrianglesDo) {
  TestRun run;
  run.dt = 2.0;
  const Figures triangles = figures_of(run_tube(run)), creeping = figures_of(run_tube_creep(run));
  run.element = ElementKind::q1;
  const Figures squares = figures_of(run_tube(run)), flowing = figures_of(run_tube_creep(run));
  const char* key = "displacement_error_nearly_incompressible";
  EXPECT_LT(squares.more.at(key), 1.2 * squares.displacement_error);
  EXPECT_GT(triangles.more.at(key), 20.0 * squares.more.at(key));
  EXPECT_LT(flowing.more.at("rate_error"), 2e-3);
  EXPECT_LT(flowing.stress_error, 0.1 * creeping.stress_error);
}

INSTANTIATE_TEST_SUITE_P(Elements, MechanicsOn,
                         ::testing::Values(ElementKind::p1, ElementKind::q1));

TEST(FictitiousLiquid, PressesTheFrontWhenItsShearIsWeaker) {
  T1Run run;
  run.liquid = FictitiousLiquid{1e-3, 2.0, 1.0};
  EXPECT_LT(run_t1(run).pressure_on_front_error, 1e-3);
  run.liquid = FictitiousLiquid{1e-3, 1.0, 2.0};
  EXPECT_GT(run_t1(run).pressure_on_front_error, 0.5);
}

TEST(T1, RefusesAMeshWithoutNodesWhereTheDataChange) {
  T1Run run;
  run.columns = 41;
  EXPECT_THROW(run_t1(run), std::invalid_argument);
  run.columns = 40, run.rows = 47;
  EXPECT_THROW(run_t1(run), std::invalid_argument);
}

/// The paper's stopping test must stop every method of the paper, and near the same solution.
class IncrementTestOf : public ::testing::TestWithParam<Algorithm> {};

TEST_P(IncrementTestOf, StopsNearTheSolutionOfTheStep) {
  TestRun run;
  run.options.algorithm = GetParam();
  run.options.parameters.gamma_p = 1e-6;
  run.options.parameters.gamma_c = 0.5e12;
  run.options.parameters.increment_test = true;
  const Figures figures = figures_of(run_t4(run));
  EXPECT_NEAR(figures.displacement_error, 0.17995, 5e-4);
  EXPECT_NEAR(figures.stress_error, 0.14408, 5e-4);
}

std::string paper_method(const ::testing::TestParamInfo<Algorithm>& method) {
  constexpr const char* names[] = {"newton", "vnbm", "sbm", "nbm"};
  return names[static_cast<int>(method.param)];
}

INSTANTIATE_TEST_SUITE_P(PaperMethods, IncrementTestOf,
                         ::testing::Values(Algorithm::sbm, Algorithm::nbm, Algorithm::vnbm),
                         paper_method);

TEST(TimeLoop, SaysWhenAPlainMethodFailed) {
  TestRun run;
  run.options.algorithm = Algorithm::nbm;
  run.options.parameters.plain = true;
  const Result result = run_t4(run);
  const auto* failed = std::get_if<Failed>(&result);
  ASSERT_NE(failed, nullptr);
  EXPECT_DOUBLE_EQ(failed->time, 0.3125);
  EXPECT_NE(failed->why.find("t = 0.3125 s"), std::string::npos);
}

}  // namespace
}  // namespace dccast::verification
