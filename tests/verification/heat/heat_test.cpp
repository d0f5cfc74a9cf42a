#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/print_kinds.hpp"
#include "tests/verification/heat/heat_runs.hpp"

namespace dccast::verification {
namespace {

using mesh::ElementKind;

TEST(NeumannSolution, HasTheKnownConstant) {
  const NeumannSolution exact{StefanData{}};
  EXPECT_NEAR(exact.similarity_constant(), 0.27296013, 5e-9);
  EXPECT_NEAR(exact.front(1.0), 4.5675e-3, 5e-8);
  EXPECT_NEAR(exact.front(6.0), 11.188e-3, 5e-7);
  EXPECT_NEAR(exact.temperature(0.010, 6.0), 651.86, 5e-3);
  EXPECT_NEAR(exact.temperature(exact.front(2.0), 2.0), 660.0, 1e-9);
}

/// The closed forms are held against their own equations by finite differences.
TEST(MushySolution, SolvesItsEquations) {
  const MushyStefanData data;
  const MushySolution exact(data);
  const double time = 6.0, step = 1e-5;
  const auto flux = [&](double depth, double conductivity, double side) {
    return conductivity *
           (exact.temperature(depth + side * step, time) - exact.temperature(depth, time)) /
           (side * step);
  };
  const double solidus = exact.solidus_front(time), liquidus = exact.liquidus_front(time);
  EXPECT_NEAR(exact.temperature(solidus, time), data.solidus, 1e-9);
  EXPECT_NEAR(exact.temperature(liquidus, time), data.liquidus, 1e-9);
  EXPECT_NEAR(
      flux(solidus, data.solid_conductivity, -1.0) / flux(solidus, data.mushy_conductivity, 1.0),
      1.0, 5e-3);
  EXPECT_NEAR(
      flux(liquidus, data.mushy_conductivity, -1.0) / flux(liquidus, data.liquid_conductivity, 1.0),
      1.0, 5e-3);
  const double middle = 0.5 * (solidus + liquidus), width = 1e-4, later = 1e-3;
  const double rate =
      (exact.temperature(middle, time + later) - exact.temperature(middle, time - later)) /
      (2 * later);
  const double curvature =
      (exact.temperature(middle + width, time) - 2 * exact.temperature(middle, time) +
       exact.temperature(middle - width, time)) /
      (width * width);
  EXPECT_NEAR(data.mushy_capacity() * rate / (data.mushy_conductivity * curvature), 1.0, 1e-3);
}

TEST(StrandSolution, SolvesItsEquation) {
  const StrandData data;
  const StrandSolution exact(data);
  EXPECT_NEAR(exact.temperature(0.0), data.top_temperature, 1e-9);
  EXPECT_NEAR(exact.temperature(data.length), data.bottom_temperature, 1e-9);
  for (const double depth : {0.03, 0.08, 0.092, 0.11, 0.14}) {
    const double t = exact.temperature(depth), step = 1e-6;
    const double slope =
        (exact.temperature(depth + step) - exact.temperature(depth - step)) / (2 * step);
    EXPECT_NEAR(data.speed * strand_enthalpy(data, t) - data.conductivity * slope,
                exact.heat_flow(), 1e-5 * exact.heat_flow());
    EXPECT_NEAR(exact.depth(t), depth, 1e-9);
  }
}

class StefanOn : public ::testing::TestWithParam<ElementKind> {};

TEST_P(StefanOn, FrontAndTemperatureAreReached) {
  const StefanFigures figures = run_stefan({}, {.element = GetParam()});
  ASSERT_TRUE(figures.size.converged);
  ASSERT_EQ(figures.front.size(), 2U);
  for (const FrontFigure& front : figures.front) EXPECT_LT(std::abs(front.relative_error()), 0.02);
  EXPECT_NEAR(figures.probe_temperature, figures.probe_exact, 0.5);
  EXPECT_LT(figures.size.worst_balance, 1e-10);
}

INSTANTIATE_TEST_SUITE_P(Elements, StefanOn, ::testing::Values(ElementKind::p1, ElementKind::q1));

TEST(Stefan, ConvergesAtFirstOrderUnderRefinement) {
  // The front's place within its cell makes single halvings irregular: order over a factor of 8.
  const auto error = [](double cell) {
    return run_stefan({}, {.cell = cell, .time_step = 5.0 * cell}).mean_temperature_error;
  };
  EXPECT_GT(observed_order(error(1e-3), error(0.125e-3), 8.0), 0.8);
}

TEST(MushyStefan, ConvergesToTheSimilaritySolution) {
  const auto run = [](double cell) {
    return run_mushy_stefan({}, {.cell = cell, .time_step = 4e4 * cell * cell});
  };
  const MushyFigures coarse = run(0.5e-3), fine = run(0.25e-3);
  ASSERT_TRUE(fine.size.converged);
  EXPECT_LT(std::abs(fine.solidus.relative_error()), 5e-3);
  EXPECT_LT(std::abs(fine.liquidus.relative_error()), 5e-3);
  EXPECT_NEAR(fine.probe_temperature, fine.probe_exact, 0.05);
  EXPECT_GT(observed_order(coarse.mean_temperature_error, fine.mean_temperature_error), 1.5);
  EXPECT_LT(fine.size.worst_balance, 1e-10);
}

TEST(Strand, ConvergesToTheClosedFormAtFirstOrder) {
  const StrandFigures coarse = run_strand({}, 200), fine = run_strand({}, 400);
  ASSERT_TRUE(fine.size.converged);
  EXPECT_NEAR(observed_order(coarse.mean_temperature_error, fine.mean_temperature_error), 1.0, 0.1);
  EXPECT_LT(fine.mean_temperature_error, 0.5);
  for (const FrontFigure& isotherm : fine.isotherm) {
    EXPECT_LT(std::abs(isotherm.relative_error()), 0.01);
  }
  EXPECT_LT(run_strand_extrapolated({}, 200).largest_temperature_error, 0.1);
}

class DecayingModeOn : public ::testing::TestWithParam<std::tuple<ElementKind, mesh::SectionKind>> {
};

TEST_P(DecayingModeOn, IsSecondOrderInSpaceAndFirstInTime) {
  const auto error = [&](int cells, int steps) {
    const auto [element, kind] = GetParam();
    return run_cosine_mode(cells, steps, element, kind).error;
  };
  EXPECT_NEAR(observed_order(error(8, 40), error(16, 160)), 2.0, 0.15);
  EXPECT_NEAR(observed_order(error(48, 20), error(48, 40)), 1.0, 0.1);
}

INSTANTIATE_TEST_SUITE_P(Sections, DecayingModeOn,
                         ::testing::Combine(::testing::Values(ElementKind::p1, ElementKind::q1),
                                            ::testing::Values(mesh::SectionKind::plane_strain,
                                                              mesh::SectionKind::axisymmetric)));

}  // namespace
}  // namespace dccast::verification
