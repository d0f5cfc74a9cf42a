#include <array>

#include "tests/regression/whole_run.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

using regression::largest_difference;
using regression::run;

casting::Case shipped() {
  return support::load_case("start-2d-thickness");
}

/// The paper's conditions: a level at the casting temperature, water with constant limits, a side
/// that is held until it is solid.
casting::Case of_the_paper() {
  casting::Case c = shipped();
  c.cooling.top = thermal::Top::held;
  c.cooling.water.boiling_follows_flow = false;
  c.alloy.shell = c.alloy.solidus;
  return c;
}

casting::Case paper_sized(mesh::ElementKind element) {
  casting::Case c = of_the_paper();
  support::take_paper_size(c);
  c.section.element = element;
  return c;
}

void expect_sound_steps(const casting::Case& c) {
  for (const auto& r : run(c)) {
    EXPECT_LE(r.energy_balance_error, 1e-10) << "t = " << r.time;
    EXPECT_NEAR(r.bottom_reaction, r.weight, 1e-4 * r.weight) << "t = " << r.time;
    EXPECT_LE(r.complementarity_error, 1e-6) << "t = " << r.time;
    EXPECT_LE(r.equilibrium_residual, 1e-8) << "t = " << r.time;
  }
}

TEST(Start2dThickness, EveryStepPassesItsOwnChecks) {
  expect_sound_steps(paper_sized(mesh::ElementKind::q1_bending));
}

TEST(Start2dThickness, EveryStepOfTheMeshAsShippedPassesItsOwnChecks) {
  expect_sound_steps(of_the_paper());
}

TEST(Start2dThickness, EveryStepAsShippedPassesItsOwnChecks) {
  expect_sound_steps(shipped());
}

/// The paper's element and size, the four algorithms one after the other: whatever they share or
/// not, the casting must not depend on who computes it.
TEST(Start2dThickness, AllAlgorithmsAgreeAtEveryMonitorAndStep) {
  casting::Case c = paper_sized(mesh::ElementKind::p1);
  c.mechanics.options.tolerance = 1e-9;
  const auto newton = run(c);
  // With this constant sbm closes its gaps in some hundred iterations a step.
  c.mechanics.options.parameters.gamma_c = 5e9;
  for (const auto algorithm :
       {mechanics::Algorithm::vnbm, mechanics::Algorithm::nbm, mechanics::Algorithm::sbm}) {
    c.mechanics.options.algorithm = algorithm;
    EXPECT_LE(largest_difference(newton, run(c)), 1e-6) << "[m], algorithm " << int(algorithm);
  }
}

/// Triangles lock in volume and in bending and Q1 in bending, yet all must tend to one answer: with
/// cells halved they are much nearer to each other, by the order 1.5 at least. 30 s of casting, in
/// which most of the curl comes about.
TEST(Start2dThickness, ElementFamiliesComeTogetherUnderRefinement) {
  const auto corner = [](mesh::ElementKind element, int refinement) {
    casting::Case c = paper_sized(element);
    c.section.refinement = refinement;
    c.time.end = 30.0;
    return run(c).back().monitor_displacement.at(0)[1];
  };
  const auto lift = [&](mesh::ElementKind element) {
    return std::array{corner(element, 1), corner(element, 2)};
  };
  const auto p1 = lift(mesh::ElementKind::p1), q1 = lift(mesh::ElementKind::q1);
  const auto bending = lift(mesh::ElementKind::q1_bending);
  const double nearer = std::pow(2.0, -1.5);
  EXPECT_LE(std::abs(q1[1] - p1[1]), nearer * std::abs(q1[0] - p1[0]));
  EXPECT_LE(std::abs(bending[1] - p1[1]), nearer * std::abs(bending[0] - p1[0]));
  EXPECT_LE(std::abs(bending[1] - q1[1]), nearer * std::abs(bending[0] - q1[0]));
}

void expect_curl_mm(const std::vector<results::StepReport>& reports, double corner, double mid,
                    double centre) {
  const auto& last = reports.back().monitor_displacement;
  EXPECT_NEAR(1e3 * last.at(0)[1], corner, 0.02);
  EXPECT_NEAR(1e3 * last.at(1)[1], mid, 0.02);
  EXPECT_NEAR(1e3 * last.at(2)[1], centre, 0.02);
}

TEST(Start2dThickness, FinalCurlOfLinearTriangles) {
  expect_curl_mm(run(paper_sized(mesh::ElementKind::p1)), 4.585, 0.986, 0.0);
}

TEST(Start2dThickness, FinalCurlOfMeanDilatationQuadrilaterals) {
  expect_curl_mm(run(paper_sized(mesh::ElementKind::q1)), 5.118, 1.169, 0.0);
}

TEST(Start2dThickness, FinalCurlOfQuadrilateralsThatBend) {
  expect_curl_mm(run(paper_sized(mesh::ElementKind::q1_bending)), 5.370, 1.251, 0.0);
}

TEST(Start2dThickness, FinalCurlUnderThePapersConditions) {
  expect_curl_mm(run(of_the_paper()), 5.335, 1.237, 0.0);
}

TEST(Start2dThickness, FinalCurlAsShipped) {
  expect_curl_mm(run(shipped()), 5.269, 1.208, 0.0);
}

}  // namespace
}  // namespace dccast
