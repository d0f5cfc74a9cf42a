#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <ostream>

#include "core/material/thermal_properties.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::all;
using testing::small_casting;

TEST(CaseCheck, AGoodCaseHasNoFaultAndAnEstimate) {
  const CheckedCase checked = check(small_casting());
  EXPECT_TRUE(checked.faults.empty()) << all(checked.faults);
  EXPECT_TRUE(checked.warnings.empty()) << all(checked.warnings);
  EXPECT_GT(checked.estimate.steps, 30);
  EXPECT_GT(checked.estimate.nodes, 8 * 7);
  EXPECT_EQ(checked.estimate.elements % 14, 0);
  EXPECT_GT(checked.estimate.solver_seconds, 0.0);
  EXPECT_GT(checked.estimate.memory_bytes, 0.0);
}

/// A more expensive case gets a higher estimate; docs/developers/decisions.md has the measured
/// accuracy.
TEST(CaseCheck, TheEstimateKnowsAlgorithmElementAndPhysics) {
  const auto seconds = [](const std::function<void(Case&)>& change) {
    Case c = small_casting(mesh::ElementKind::q1);
    change(c);
    return check(c).estimate.solver_seconds;
  };
  const double newton = seconds([](Case&) {});
  const auto by = [](mechanics::Algorithm algorithm) {
    return [=](Case& c) { c.mechanics.options.algorithm = algorithm; };
  };
  EXPECT_GT(seconds(by(mechanics::Algorithm::vnbm)), 2.0 * newton);
  EXPECT_GT(seconds(by(mechanics::Algorithm::sbm)), 10.0 * newton);
  EXPECT_LT(seconds([](Case& c) { c.mechanics.enabled = false; }), 0.5 * newton);
  EXPECT_GT(seconds([](Case& c) { c.section.refinement = 2; }), 4.0 * newton);
  EXPECT_GT(seconds([](Case& c) { c.coupling.iterations = 3; }), 2.0 * newton);
  EXPECT_GT(seconds([](Case& c) { c.section.kind = mesh::SectionKind::axisymmetric; }), newton);
}

struct Mistake {
  const char* name;
  const char* field;
  std::function<void(Case&)> make;
};
void PrintTo(const Mistake& m, std::ostream* out) {
  *out << m.name;
}

class CaseFault : public ::testing::TestWithParam<Mistake> {};

/// Each fault states the key, the problem, the permitted range and the remedy.
TEST_P(CaseFault, IsFoundAndSaysHowToMendIt) {
  Case c = small_casting();
  GetParam().make(c);
  const CheckedCase checked = check(c);
  bool found = false;
  for (const Fault& fault : checked.faults.list()) {
    EXPECT_FALSE(fault.field.empty());
    EXPECT_FALSE(fault.message.empty()) << fault.field;
    EXPECT_FALSE(fault.permitted.empty()) << fault.field << ": " << fault.message;
    EXPECT_FALSE(fault.remedy.empty()) << fault.field << ": " << fault.message;
    found |= fault.field == GetParam().field;
  }
  EXPECT_TRUE(found) << GetParam().field << " is not among:\n" << all(checked.faults);
}

const Mistake mistakes[] = {
    {"PureMetal", "alloy.solidus", [](Case& c) { c.alloy.solidus = c.alloy.liquidus; }},
    {"NearlyPureMetal", "alloy.solidus", [](Case& c) { c.alloy.solidus = c.alloy.liquidus - 0.5; }},
    {"SolidusAboveLiquidus", "alloy.solidus", [](Case& c) { c.alloy.solidus = 650.0; }},
    {"CoherencyAboveLiquidus", "alloy.coherency", [](Case& c) { c.alloy.coherency = 700.0; }},
    {"YieldLimitWithAPaperAlgorithm", "mechanics.algorithm",
     [](Case& c) {
       c.alloy.cold_strength.emplace();
       c.mechanics.options.algorithm = mechanics::Algorithm::vnbm;
     }},
    {"GapWaterBesideAWetCoefficient", "cooling.bottom_block.gap_water",
     [](Case& c) {
       c.cooling.water.boiling_follows_flow = true;
       c.cooling.bottom_block.gap_water.emplace();
       c.cooling.bottom_block.wet_coefficient = 2000.0;
     }},
    {"GapWaterUnderAFaceWithoutAFilm", "cooling.bottom_block.gap_water",
     [](Case& c) {
       c.cooling.water.boiling_follows_flow = false;
       c.cooling.bottom_block.gap_water.emplace();
     }},
    {"OnsetOfStressAboveTheShell", "alloy.coherency_solid_fraction",
     [](Case& c) {
       c.alloy.mush.emplace();
       c.coherency_solid_fraction = 0.95;
       c.alloy.coherency = material::coherency_at(c.alloy, 0.95);
       c.alloy.shell = material::coherency_at(c.alloy, 0.9);
     }},
    {"CoherencyInTwoWays", "alloy.coherency_solid_fraction",
     [](Case& c) {
       c.alloy.coherency = 630.0;
       c.coherency_solid_fraction = 1.0;
     }},
    {"BandUpsideDown", "plausibility.greatest_curl",
     [](Case& c) {
       c.plausibility.least_curl = 0.04;
       c.plausibility.greatest_curl = 0.03;
     }},
    {"TableNotIncreasing", "alloy.density",
     [](Case& c) {
       c.alloy.density = {Abscissa::temperature, {0, 649, 620}, {2700, 2360, 2557}};
     }},
    {"SpeedNotIncreasing", "schedule.casting_speed",
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {0, 0}, {1e-3, 2e-3}};
     }},
    {"StepsNotIncreasing", "time.step",
     [](Case& c) {
       c.time.step = {Abscissa::time, {5, 1}, {1, 1}};
     }},
    {"MonitorBesideTheSlab", "monitor[1].x", [](Case& c) { c.monitors[1].x = 0.3; }},
    {"MonitorAboveTheSlab", "monitor[2].y", [](Case& c) { c.monitors[2].y = 0.13; }},
    {"MonitorTwice", "monitor[1].name", [](Case& c) { c.monitors[1].name = "corner"; }},
    {"MeanOfNothing", "monitor[3].of[1].monitor",
     [](Case& c) {
       c.monitors.push_back({.name = "plant", .of = {{"corner", 2.0}, {"edge", 1.0}}});
     }},
    {"MeanOfAMean", "monitor[3].of[0].monitor",
     [](Case& c) {
       c.monitors.push_back({.name = "plant", .of = {{"plant", 1.0}}});
     }},
    {"MeanOfOnePointTwice", "monitor[3].of[1].monitor",
     [](Case& c) {
       c.monitors.push_back({.name = "plant", .of = {{"corner", 2.0}, {"corner", 1.0}}});
     }},
    {"CurlOfNoMonitor", "output.curl", [](Case& c) { c.output.curl = "plant"; }},
    {"TooManyNodes", "mesh.columns", [](Case& c) { c.limits.maximum_nodes = 60; }},
    {"BottomCellSoHighThatTopRowsAreNothing", "mesh.columns",
     [](Case& c) {
       c.section.growth_cell = {};
       c.section.bottom_cell = c.section.initial_depth * (1.0 - 1e-9);
     }},
    {"GrowthCellOfNothingInATopRow", "mesh.columns",
     [](Case& c) {
       c.section.growth_cell = 1e-20;  // heights that no number can tell apart
       c.schedule.casting_speed = Curve(0.0);
     }},
    {"GrowthCellOfMicrometres", "mesh.columns", [](Case& c) { c.section.growth_cell = 1e-9; }},
    {"TooManySteps", "time.step", [](Case& c) { c.limits.maximum_steps = 20; }},
    {"UnreadableMesh", "mesh.file",
     [](Case& c) {
       c.section.file = "nowhere.msh";
       c.section.growth = false;
     }},
    {"UnreadableTemperature", "thermal.file",
     [](Case& c) {
       c.thermal.file = "nowhere.h5";
       c.section.growth = false;
     }},
    {"OverlappingZones", "cooling.zone[1].from", [](Case& c) { c.cooling.zones[1].from = 0.02; }},
    {"ZoneUpsideDown", "cooling.zone[0].to", [](Case& c) { c.cooling.zones[0].to = -0.01; }},
    {"FaceOfASection", "cooling.zone[0].face",
     [](Case& c) { c.cooling.zones[0].face = thermal::Face::narrow; }},
    {"NarrowWaterOfASection", "cooling.narrow_water",
     [](Case& c) { c.cooling.narrow_water = c.cooling.water; }},
    {"NarrowFlowOfASection", "schedule.narrow_water_flow",
     [](Case& c) { c.schedule.narrow_water_flow = Curve(1e-3); }},
    {"PulsesShorterThanAStep", "cooling.water.pulse_period",
     [](Case& c) {
       c.cooling.water.pulse_period = 1.5e-3;
       c.cooling.water.pulse_end = 0.01;
     }},
    {"MorePulsesThanSteps", "cooling.water.pulse_period",
     [](Case& c) {
       c.limits.maximum_steps = 100;
       c.cooling.water.pulse_period = 0.2;
       c.cooling.water.pulse_end = 15.0;
     }},
    {"SecondWaterAboveTheFirst", "cooling.second_water.from",
     [](Case& c) {
       c.cooling.second_water = {.from = 0.065};
       c.schedule.second_water_flow = Curve(1e-3);
     }},
    {"SecondWaterWithoutFlow", "cooling.second_water",
     [](Case& c) { c.cooling.second_water = {.from = 0.1}; }},
    {"SecondFlowWithoutPlace", "schedule.second_water_flow",
     [](Case& c) { c.schedule.second_water_flow = Curve(1e-3); }},
    {"LevelThatFallsFasterThanTheBlock", "schedule.metal_level",
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::time, {5.0, 15.0}, {0.0, -0.011}};
     }},
    {"LevelThatFallsFasterThanASlowBlock", "schedule.metal_level",
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {0.0, 10.0, 20.0}, {2e-3, 1e-4, 2e-3}};
       c.schedule.metal_level = {Abscissa::time, {0.0, 20.0}, {0.0, -0.01}};
     }},
    {"LevelThatFallsFasterThanTheCastLength", "schedule.metal_level",
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::cast_length, {0.0, 9e-3}, {0.0, -0.01}};
     }},
    {"LevelThatIsNotThatOfTheStart", "schedule.metal_level",
     [](Case& c) { c.schedule.metal_level = Curve(0.01); }},
    {"LevelBelowTheWater", "schedule.metal_level",
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::cast_length, {0.0, 1.0}, {0.0, -0.1}};
     }},
    {"LevelOutOfOrder", "schedule.metal_level",
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::time, {5.0, 4.0}, {0.0, 0.0}};
     }},
    {"GasOutOfOrder", "cooling.water.critical_heat_flux_factor",
     [](Case& c) {
       c.cooling.water.critical_heat_flux_factor = {Abscissa::cast_length, {0.1, 0.1}, {0.3, 1.0}};
     }},
    {"NarrowWaterTemperatureOutOfOrder", "cooling.narrow_water.temperature",
     [](Case& c) {
       c.cooling.narrow_water = c.cooling.water;
       c.cooling.narrow_water->temperature = {Abscissa::time, {5.0, 4.0}, {20.0, 30.0}};
     }},
    {"LevelOfASlabThatDoesNotGrow", "schedule.metal_level",
     [](Case& c) {
       c.section.growth = false;
       c.schedule.metal_level = Curve(0.0);
     }},
    {"WaterTemperatureOutOfOrder", "cooling.water.temperature",
     [](Case& c) {
       c.cooling.water.temperature = {Abscissa::cast_length, {0.1, 0.1}, {20.0, 30.0}};
     }},
    {"FactorBeyondTheRange", "schedule.casting_speed_factor",
     [](Case& c) { c.schedule.casting_speed_factor = Curve(100.5); }},
    {"FlowFactorBeyondTheRange", "schedule.water_flow_factor",
     [](Case& c) { c.schedule.water_flow_factor = Curve(60.0); }},
    {"ShiftOfATableAgainstLength", "schedule.water_flow_shift",
     [](Case& c) {
       c.schedule.water_flow = {Abscissa::cast_length, {0.0, 0.1}, {1e-3, 3e-3}};
       c.schedule.water_flow_shift = 5.0;
     }},
    {"FactorNotIncreasing", "schedule.water_flow_factor",
     [](Case& c) {
       c.schedule.water_flow_factor = {Abscissa::time, {5, 5}, {1, 2}};
     }},
    {"ImportedMeshThatGrows", "mesh.growth", [](Case& c) { c.section.file = "slab.msh"; }},
    {"TemperatureOfASlabThatGrows", "thermal.file", [](Case& c) { c.thermal.file = "t.h5"; }},
    {"FillingLongerThanTheHold", "schedule.filling", [](Case& c) { c.schedule.filling = 10.5; }},
    {"FillingOfASlabThatDoesNotGrow", "schedule.filling",
     [](Case& c) {
       c.schedule.filling = 5.0;
       c.section.growth = false;
     }},
    {"MechanicsBeforeTheMouldIsFull", "mechanics.start",
     [](Case& c) {
       c.schedule.filling = 5.0;
       c.mechanics.start = -6.0;
     }},
    {"AlloyWithoutDensity", "alloy.density", [](Case& c) { c.alloy.density = {}; }},
    {"AlloyWithoutConductivity", "alloy.conductivity", [](Case& c) { c.alloy.conductivity = {}; }},
    {"GrowthCellTooHigh", "mesh.growth_cell", [](Case& c) { c.section.growth_cell = 0.2; }},
    {"SideCellTooWide", "mesh.side_cell", [](Case& c) { c.section.side_cell = 0.3; }},
    {"BottomCellTooHigh", "mesh.bottom_cell", [](Case& c) { c.section.bottom_cell = 0.3; }},
    {"BilletThatTurns", "mechanics.kinematics",
     [](Case& c) {
       c.section.kind = mesh::SectionKind::axisymmetric;
       c.section.element = mesh::ElementKind::q1_bending;
       c.mechanics.options.kinematics = mechanics::Kinematics::corotational;
     }},
    {"TrianglesOfABillet", "mesh.element",
     [](Case& c) { c.section.kind = mesh::SectionKind::axisymmetric; }},
    {"EndBeforeTheBeginning", "time.end", [](Case& c) { c.time.end = -11.0; }},
    {"MinimumAboveTheSteps", "time.minimum_step", [](Case& c) { c.time.minimum_step = 0.5; }},
    {"YosidaIndexTooLarge", "mechanics.parameters.lambda_p",
     [](Case& c) {
       c.mechanics.options.algorithm = mechanics::Algorithm::sbm;
       c.mechanics.options.parameters.lambda_p = 2.0 / c.mechanics.options.parameters.gamma_p;
     }},
};
INSTANTIATE_TEST_SUITE_P(Mistakes, CaseFault, ::testing::ValuesIn(mistakes),
                         [](const auto& mistake) { return mistake.param.name; });

TEST(CaseCheck, NamesAllFaultsInOneAnswer) {
  Case c = small_casting();
  c.alloy.solidus = 660.0;
  c.cooling.zones[1].from = 0.01;
  c.time.minimum_step = 2.0;
  c.section.side_cell = 1.0;
  EXPECT_GE(check(c).faults.list().size(), 4u);
}

std::vector<std::string> fields(const Faults& faults) {
  std::vector<std::string> names;
  for (const Fault& fault : faults.list()) names.push_back(fault.field);
  return names;
}

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::Not;

/// Faults of alloy, geometry and time are reported independently of each other.
TEST(CaseCheck, AFaultHidesNothingThatDoesNotFollowFromIt) {
  Case c = small_casting();
  c.alloy.solidus = 650.0;
  c.section.side_cell = 0.3;
  c.time.minimum_step = 0.5;
  c.limits.maximum_nodes = 60;
  c.monitors[1].x = 0.3;
  c.monitors[2].y = 0.13;
  EXPECT_THAT(fields(check(c).faults),
              ElementsAre("alloy.solidus", "mesh.side_cell", "time.minimum_step", "mesh.columns",
                          "monitor[1].x", "monitor[2].y"));
}

TEST(CaseCheck, WhatFollowsFromAValueAtFaultWaitsForItAndSaysSo) {
  Case c = small_casting();
  c.section.half_width = -1.0;  // out of its range, which was found before
  c.monitors[1].x = 0.3;
  c.monitors[2].y = 0.13;
  const CheckedCase checked = check(c, {"section.half_width"});
  EXPECT_THAT(fields(checked.faults), ElementsAre("monitor[2].y"));
  EXPECT_THAT(fields(checked.warnings), ElementsAre("section.half_width"));
  EXPECT_THAT(checked.warnings.list()[0].message, ::testing::HasSubstr("wait until this is fixed"));
}

TEST(CaseCheck, ADensityThatIsMixedWaitsForBoth) {
  Case c = small_casting();
  c.alloy.solid_density = c.alloy.density;
  c.alloy.density = {};  // it is mixed once the liquid's is sound
  EXPECT_THAT(fields(check(c, {"alloy.liquid_density"}).faults), IsEmpty());
}

TEST(CaseCheck, APureMetalHasHeatAloneAndItsRemedyIsAccepted) {
  Case c = small_casting();
  c.alloy.solidus = c.alloy.liquidus;
  EXPECT_THAT(fields(check(c).faults), ElementsAre("alloy.solidus"));
  EXPECT_THAT(check(c).faults.list()[0].remedy, ::testing::HasSubstr("mechanics.enabled = false"));
  c.alloy.solidus = c.alloy.liquidus - 1.0;
  EXPECT_THAT(fields(check(c).faults), IsEmpty());
  c.alloy.solidus = c.alloy.liquidus;
  c.mechanics.enabled = false;
  EXPECT_THAT(fields(check(c).faults), IsEmpty());
}

/// Specific heat of a calorimeter, with a peak of all or half of the latent heat, in the mush or
/// wider, or a step.
TEST(CaseCheck, ARemarkSaysThatTheLatentHeatCountsTwice) {
  Case c = small_casting();
  const material::AlloyCard& a = c.alloy;
  const double middle = 0.5 * (a.solidus + a.liquidus), half = 0.5 * (a.liquidus - a.solidus);
  const auto warned = [&](double share, double width) {
    const double top = 1100.0 + share * a.latent_heat / width;
    c.alloy.specific_heat =
        Curve(Abscissa::temperature, {20.0, middle - width, middle, middle + width, 900.0},
              {900.0, 1100.0, top, 1100.0, 1100.0});
    return !fields(check(c).warnings).empty();
  };
  EXPECT_TRUE(warned(1.0, half));
  EXPECT_TRUE(warned(1.0, 1.0));
  EXPECT_TRUE(warned(0.5, half + 25.0));
  EXPECT_TRUE(warned(0.3, half));
  EXPECT_FALSE(warned(0.02, half));
  EXPECT_FALSE(warned(0.0, half));

  c.alloy.specific_heat = Curve(Abscissa::temperature, {a.solidus, a.liquidus}, {900.0, 1200.0});
  EXPECT_THAT(fields(check(c).warnings), IsEmpty()) << "liquid holds more than solid";
  c.alloy.latent_heat = 0.0;
  EXPECT_FALSE(warned(1.0, half));
}

TEST(CaseCheck, ASoundCaseWaitsForNothing) {
  EXPECT_THAT(fields(check(small_casting(), {"title"}).warnings), IsEmpty());
}

TEST(CaseCheck, AFaultInOnePointOfATableIsOneOfTheTable) {
  Case c = small_casting();
  c.monitors[2].y = 0.13;
  const CheckedCase checked = check(c, {"schedule.casting_speed[1]", "alloy.card"});
  EXPECT_THAT(fields(checked.faults), IsEmpty());  // the final metal level is unknown
  EXPECT_THAT(fields(checked.warnings), ElementsAre("alloy.card", "schedule.casting_speed[1]"));
}

TEST(CaseCheck, WhatItFindsItselfIsWaitedForToo) {
  Case c = small_casting();
  c.limits.maximum_steps = 20;
  c.monitors[1].x = 0.3;
  c.monitors[2].y = 7.0;
  const CheckedCase checked = check(c);
  EXPECT_THAT(fields(checked.faults), ElementsAre("time.step", "monitor[1].x"));
  EXPECT_THAT(fields(checked.warnings), ElementsAre("time.step"));
}

/// No faults are invented for a case that could hardly be read.
TEST(CaseCheck, ACaseWithoutItsRequiredKeysIsSurvived) {
  Case c;
  c.limits.maximum_nodes = 1000;  // every case has limits
  c.monitors = {{"a", 0.1, 0.1}, {"a", 0.2, 0.1}};
  const CheckedCase checked =
      check(c, {"section.half_width", "section.initial_depth", "alloy.card", "time.end",
                "time.step", "schedule.casting_speed", "schedule.casting_temperature"});
  EXPECT_THAT(fields(checked.faults), ElementsAre("monitor[1].name"));
  EXPECT_THAT(fields(checked.warnings), Contains("time.step"));
}

TEST(CaseCheck, AMeshThatCannotBeReadIsWaitedForByItsMonitorsAndTemperatures) {
  Case c = small_casting();
  c.section.file = "nowhere.msh";
  c.section.growth = false;
  c.thermal.file = "nowhere.h5";
  c.monitors[1].name = "corner";
  const CheckedCase checked = check(c);
  EXPECT_THAT(fields(checked.faults), ElementsAre("mesh.file", "monitor[1].name"));
  EXPECT_THAT(fields(checked.warnings), ElementsAre("mesh.file"));
}

/// 1e8 steps within the limit: a loop over them took seconds and delayed other queries.
TEST(CaseCheck, CountsAHundredMillionStepsAtOnce) {
  Case c = small_casting();
  c.time.step = Curve(1e-6);
  c.time.end = 90.0;
  c.limits.maximum_steps = 1000000000;
  c.limits.maximum_nodes = 100000;
  const auto start = std::chrono::steady_clock::now();
  const CheckedCase checked = check(c);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
  EXPECT_THAT(fields(checked.faults), Not(Contains("time.step")));
  EXPECT_NEAR(static_cast<double>(checked.estimate.steps), 1e8, 1e3);
  EXPECT_LT(took.count(), 0.2);
}

TEST(CaseCheck, AMonitorMayWaitForItsMetal) {
  Case c = small_casting();
  c.monitors[2].y = 0.1199;  // the level reaches 0.12 m
  EXPECT_TRUE(check(c).faults.empty());
}

TEST(CaseCheck, WarnsOfACaseThatShowsNothing) {
  Case c = small_casting();
  c.monitors.clear();
  c.mechanics.start = 30.0;
  const CheckedCase checked = check(c);
  EXPECT_TRUE(checked.faults.empty());
  EXPECT_EQ(checked.warnings.list().size(), 2u);
}

}  // namespace
}  // namespace dccast::casting
