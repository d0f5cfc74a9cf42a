#include "core/casting/findings/rules.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <ostream>
#include <set>
#include <utility>

#include "core/casting/findings/judge.hpp"
#include "core/casting/forecast.hpp"
#include "core/casting/simulation.hpp"
#include "core/results/result_reader.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::bytes_of;
using testing::small_casting;

const Finding* find(const std::vector<Finding>& findings, const std::string& code) {
  const auto found = std::ranges::find(findings, code, &Finding::code);
  return found == findings.end() ? nullptr : &*found;
}

/// Every finding is a sentence, and has value, limit and unit, or none of them.
void expect_complete(const Finding& finding) {
  EXPECT_TRUE(finding.message.ends_with(".")) << finding.message;
  EXPECT_EQ(finding.value.has_value(), finding.limit.has_value());
  EXPECT_EQ(finding.value.has_value(), !finding.unit.empty());
}

/// A change of a case that raises a finding, and one that just does not.
struct CaseRow {
  const char* name;
  const char* code;
  std::function<void(Case&)> raises;
  std::function<void(Case&)> does_not;
};
void PrintTo(const CaseRow& c, std::ostream* out) {
  *out << c.name;
}

class OfCase : public ::testing::TestWithParam<CaseRow> {};

TEST_P(OfCase, IsRaisedBeyondItsLimitAndJustNotAtIt) {
  const CaseRow& row = GetParam();
  Case beyond = small_casting(), within = small_casting();
  row.raises(beyond);
  row.does_not(within);

  const auto findings = findings_of_case(beyond);
  const Finding* raised = find(findings, row.code);
  ASSERT_NE(raised, nullptr);
  EXPECT_FALSE(raised->time) << "it follows from the case alone";
  expect_complete(*raised);

  EXPECT_EQ(find(findings_of_case(within), row.code), nullptr);
}

void set_mush_of_5182(Case& c, double coherency) {
  c.alloy.solidus = 515.0;
  c.alloy.liquidus = 637.0;
  c.alloy.coherency = coherency;
}

// The small casting ends after 20 s with 0.02 m cast, 0.12 m deep.
const CaseRow of_case_rows[] = {
    {"NoSuperheat", "no_superheat", [](Case& c) { c.schedule.casting_temperature = Curve(653.9); },
     [](Case& c) { c.schedule.casting_temperature = Curve(654.0); }},
    {"SuperheatThatIsLostOnTheWay", "no_superheat",
     [](Case& c) {
       c.schedule.casting_temperature = {Abscissa::time, {0.0, 20.0}, {680.0, 650.0}};
     },
     [](Case& c) {
       c.schedule.casting_temperature = {Abscissa::time, {20.0, 40.0}, {680.0, 600.0}};
     }},
    {"CoherencyOfAnotherCard", "coherency_in_liquid", [](Case& c) { set_mush_of_5182(c, 620.0); },
     [](Case& c) { set_mush_of_5182(c, 576.0); }},
    {"CoherencyBelowTheSolidus", "coherency_in_liquid", [](Case& c) { set_mush_of_5182(c, 514.0); },
     [](Case& c) { set_mush_of_5182(c, 515.0); }},
    {"WaterOff", "water_never_meets", [](Case& c) { c.cooling.water.enabled = false; },
     [](Case&) {}},
    {"WaterTooLate", "water_never_meets", [](Case& c) { c.cooling.water.start = 20.0; },
     [](Case& c) { c.cooling.water.start = 19.9; }},
    {"WaterTooLow", "water_never_meets", [](Case& c) { c.cooling.water.from = 0.1201; },
     [](Case& c) { c.cooling.water.from = 0.1199; }},
    {"WaterWithoutFlow", "water_never_meets",
     [](Case& c) {
       c.schedule.water_flow = {Abscissa::time, {20.0, 30.0}, {0.0, 1e-3}};
     },
     [](Case& c) {
       c.schedule.water_flow = {Abscissa::time, {19.0, 30.0}, {0.0, 1e-3}};
     }},
    {"WaterOfAllFaces", "water_beyond_plants",
     [](Case& c) { c.schedule.water_flow = Curve(401.0 / 60e3); },
     [](Case& c) { c.schedule.water_flow = Curve(399.0 / 60e3); }},
    {"WaterOfAllFacesByItsFactor", "water_beyond_plants",
     [](Case& c) {
       c.schedule.water_flow = Curve(201.0 / 60e3);
       c.schedule.water_flow_factor = Curve(2.0);
     },
     [](Case& c) {
       c.schedule.water_flow = Curve(199.0 / 60e3);
       c.schedule.water_flow_factor = Curve(2.0);
     }},
    {"ZoneTooLow", "zone_never_meets",
     [](Case& c) {
       c.cooling.water.enabled = false;
       c.cooling.zones[1].from = 0.1201;
     },
     [](Case& c) {
       c.cooling.water.enabled = false;
       c.cooling.zones[1].from = 0.1199;
     }},
    {"ZoneUnderWater", "zone_never_meets",
     [](Case& c) {
       c.cooling.water.start = -10.0;
       c.cooling.zones[1].from = 0.065;
     },
     [](Case& c) { c.cooling.zones[1].from = 0.065; }},
    {"SpeedTable", "table_never_reached",
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {20.0, 30.0}, {1e-3, 2e-3}};
     },
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {19.0, 30.0}, {1e-3, 2e-3}};
     }},
    {"ShiftedSpeedTable", "table_never_reached",
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {10.0, 30.0}, {1e-3, 2e-3}};
       c.schedule.casting_speed_shift = 10.0;
     },
     [](Case& c) {
       c.schedule.casting_speed = {Abscissa::time, {10.0, 30.0}, {1e-3, 2e-3}};
       c.schedule.casting_speed_shift = 9.0;
     }},
    {"WaterFactor", "table_never_reached",
     [](Case& c) {
       c.schedule.water_flow_factor = {Abscissa::cast_length, {0.021, 0.1}, {0.8, 1.0}};
     },
     [](Case& c) {
       c.schedule.water_flow_factor = {Abscissa::cast_length, {0.019, 0.1}, {0.8, 1.0}};
     }},
    {"WaterTableAgainstLength", "table_never_reached",
     [](Case& c) {
       c.schedule.water_flow = {Abscissa::cast_length, {0.021, 0.1}, {1e-3, 2e-3}};
     },
     [](Case& c) {
       c.schedule.water_flow = {Abscissa::cast_length, {0.019, 0.1}, {1e-3, 2e-3}};
     }},
    {"LevelTable", "table_never_reached",
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::cast_length, {0.021, 0.1}, {0.0, 0.02}};
     },
     [](Case& c) {
       c.schedule.metal_level = {Abscissa::cast_length, {0.019, 0.1}, {0.0, 0.02}};
     }},
    {"SecondWaterTable", "table_never_reached",
     [](Case& c) {
       c.schedule.second_water_flow = {Abscissa::time, {20.0, 30.0}, {0.0, 1e-3}};
     },
     [](Case& c) {
       c.schedule.second_water_flow = {Abscissa::time, {19.0, 30.0}, {0.0, 1e-3}};
     }},
    {"NarrowGasTable", "table_never_reached",
     [](Case& c) {
       c.cooling.narrow_water = c.cooling.water;
       c.cooling.narrow_water->critical_heat_flux_factor = {
           Abscissa::cast_length, {0.021, 0.1}, {0.5, 1.0}};
     },
     [](Case& c) {
       c.cooling.narrow_water = c.cooling.water;
       c.cooling.narrow_water->critical_heat_flux_factor = {
           Abscissa::cast_length, {0.019, 0.1}, {0.5, 1.0}};
     }},
    {"MouldTable", "table_never_reached",
     [](Case& c) {
       c.cooling.zones[0].solid_coefficient = {Abscissa::time, {-30.0, -10.0}, {200.0, 150.0}};
     },
     [](Case& c) {
       c.cooling.zones[0].solid_coefficient = {Abscissa::time, {-30.0, -9.0}, {200.0, 150.0}};
     }},
};
INSTANTIATE_TEST_SUITE_P(Findings, OfCase, ::testing::ValuesIn(of_case_rows),
                         [](const auto& row) { return row.param.name; });

TEST(OfCase, MetalBelowItsLiquidusIsADangerAndLittleSuperheatAWarning) {
  Case c = small_casting();
  c.schedule.casting_temperature = Curve(600.0);
  EXPECT_EQ(find(findings_of_case(c), "no_superheat")->severity, Severity::danger);
  c.schedule.casting_temperature = Curve(650.0);
  EXPECT_EQ(find(findings_of_case(c), "no_superheat")->severity, Severity::warning);
}

TEST(OfCase, ManyTablesAreOneFinding) {
  Case c = small_casting();
  c.schedule.casting_speed = c.schedule.water_flow = {Abscissa::time, {20.0, 30.0}, {1e-3, 2e-3}};
  const auto findings = findings_of_case(c);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_THAT(findings[0].message,
              ::testing::HasSubstr("schedule.casting_speed, schedule.water_flow"));
}

/// Figures of a step of the small casting that raise no finding.
StepFigures sound_step() {
  StepFigures f;
  f.time = 12.5;
  f.moves = f.mechanical = f.left_mould = f.left_contact = f.in_gap = true;

  f.metal_depth = 0.2;
  f.sump_depth = 0.1;
  f.exit_surface = {400.0, {0.28, 0.1}};
  f.exit_shell = {0.04, {0.24, 0.1}};
  f.least_shell = {0.02, {0.26, 0.12}};
  f.least_shell_depth = 0.03;
  f.shell_begins = {0.015, {0.28, 0.185}};
  f.gap_entry = 600.0;
  f.entry_shell = 0.02;
  f.gap_surface = {590.0, {0.28, 0.12}};
  f.bottom_shell = {0.03, {0.1, 0.0}};
  f.thickest_bottom_shell = 0.035;

  f.weight = f.bottom_reaction = 1000.0;
  f.rotation.place = f.slip.place = {0.28, 0.0};
  f.lift = {0.01, {0.28, 0.0}};
  f.greatest_curl = 0.01;
  return f;
}

/// A change of a step that raises a finding, and one that just does not.
struct StepRow {
  const char* name;
  const char* code;
  Severity severity;
  std::function<void(StepFigures&)> raises;
  std::function<void(StepFigures&)> does_not;
};
void PrintTo(const StepRow& s, std::ostream* out) {
  *out << s.name;
}

Case with_band() {
  Case c = small_casting();
  c.plausibility.reference_tear_rate = 0.18e-3;
  c.plausibility.reference_tear_pressure = 85e3;
  c.plausibility.minimum_meniscus = 5e-3;
  c.plausibility.greatest_steam_share = 0.5;
  c.plausibility.least_curl = 0.005;
  c.plausibility.greatest_curl = 0.045;
  c.validity.maximum_rotation = 10.0 * std::numbers::pi / 180.0;
  return c;
}

class OfStep : public ::testing::TestWithParam<StepRow> {};

TEST_P(OfStep, IsRaisedBeyondItsLimitAndJustNotAtIt) {
  const StepRow& row = GetParam();
  StepFigures beyond = sound_step(), within = sound_step();
  row.raises(beyond);
  row.does_not(within);

  FindingsState state, none;
  judge(with_band(), beyond, state);
  const Finding* raised = find(state.raised, row.code);
  ASSERT_NE(raised, nullptr);
  EXPECT_EQ(raised->time, 12.5);
  EXPECT_EQ(raised->severity, row.severity);
  expect_complete(*raised);
  // Which lever helps is computed (dccast remedy), not claimed.
  EXPECT_EQ(raised->message.find(" help"), std::string::npos) << raised->message;

  ASSERT_TRUE(raised->worst);
  EXPECT_EQ(raised->worst->time, 12.5);
  EXPECT_EQ(raised->worst->value, raised->value);
  EXPECT_EQ(raised->worst->place, raised->place);

  judge(with_band(), within, none);
  EXPECT_EQ(find(none.raised, row.code), nullptr);
}

const StepRow of_step_rows[] = {
    {"SurfaceAboveTheSolidus", "bleed_out_at_exit", Severity::danger,
     [](StepFigures& f) { f.exit_surface.value = 620.1; },
     [](StepFigures& f) { f.exit_surface.value = 620.0; }},
    {"ThinShellAtTheExit", "bleed_out_at_exit", Severity::danger,
     [](StepFigures& f) { f.exit_shell.value = 4.9e-3; },
     [](StepFigures& f) { f.exit_shell.value = 5e-3; }},
    {"ThinShellInTheMould", "bleed_out_at_exit", Severity::danger,
     [](StepFigures& f) { f.exit_shell.value = 0.0; },
     [](StepFigures& f) {
       f.exit_shell.value = 0.0;
       f.left_mould = false;
     }},
    {"RemeltingInTheGap", "remelting_in_gap", Severity::warning,
     [](StepFigures& f) { f.gap_surface.value = 620.1; },
     [](StepFigures& f) { f.gap_surface.value = 620.0; }},
    {"GapOfAShellThatIsNotSolidYet", "remelting_in_gap", Severity::warning,
     [](StepFigures& f) { f.gap_surface.value = 625.0; },
     [](StepFigures& f) { f.gap_surface.value = f.gap_entry = 625.0; }},
    {"BottomShellOverAGap", "bleed_out_at_bottom", Severity::danger,
     [](StepFigures& f) {
       f.bottom_shell.value = 4.9e-3;
       f.gap_under_shell = 0.3e-3;
     },
     [](StepFigures& f) {
       f.bottom_shell.value = 5e-3;
       f.gap_under_shell = 0.3e-3;
     }},
    {"BottomShellOnTheBlock", "bottom_shell_open", Severity::warning,
     [](StepFigures& f) { f.bottom_shell.value = 4.9e-3; },
     [](StepFigures& f) {
       f.bottom_shell.value = 4.9e-3;
       f.gap_under_shell = 0.3e-3;
     }},
    {"BottomShellThatMelts", "bottom_shell_fails", Severity::warning,
     [](StepFigures& f) { f.bottom_shell.value = 14.9e-3; },
     [](StepFigures& f) { f.bottom_shell.value = 15.1e-3; }},
    {"BottomShellThatWasNeverThick", "bottom_shell_fails", Severity::warning,
     [](StepFigures& f) {
       f.bottom_shell.value = 8.9e-3;
       f.thickest_bottom_shell = 15e-3;
     },
     [](StepFigures& f) {
       f.bottom_shell.value = 9.1e-3;
       f.thickest_bottom_shell = 15e-3;
     }},
    {"SteamUnderTheButt", "steam_lifts_butt", Severity::warning,
     [](StepFigures& f) { f.steam_share = 0.51; }, [](StepFigures& f) { f.steam_share = 0.5; }},
    {"DeepSump", "sump_too_deep", Severity::danger, [](StepFigures& f) { f.sump_depth = 0.1901; },
     [](StepFigures& f) { f.sump_depth = 0.1899; }},
    {"MeltedShell", "shell_melted_through", Severity::danger,
     [](StepFigures& f) {
       f.closed_shell = {0.0, {0.1, 0.0}};
     },
     [](StepFigures& f) {
       f.closed_shell = {1e-6, {0.1, 0.0}};
     }},
    {"Energy", "energy_not_conserved", Severity::danger,
     [](StepFigures& f) { f.energy_balance_error = -1.1e-8; },
     [](StepFigures& f) { f.energy_balance_error = -1e-8; }},
    {"Weight", "weight_not_carried", Severity::danger,
     [](StepFigures& f) { f.bottom_reaction = 0.98 * f.weight; },
     [](StepFigures& f) { f.bottom_reaction = 0.991 * f.weight; }},
    {"Contact", "contact_violated", Severity::danger,
     [](StepFigures& f) { f.complementarity_error = 1.1e-3; },
     [](StepFigures& f) { f.complementarity_error = 1e-3; }},
    {"Slip", "slip_too_large", Severity::danger, [](StepFigures& f) { f.slip.value = 20.1e-3; },
     [](StepFigures& f) { f.slip.value = 19.9e-3; }},
    {"Rotation", "rotation_too_large", Severity::danger,
     [](StepFigures& f) { f.rotation.value = 0.175; },
     [](StepFigures& f) { f.rotation.value = 0.174; }},
    {"Lift", "lift_too_large", Severity::danger,  // 0.28 m times tan 10 degrees is 49.4 mm
     [](StepFigures& f) { f.lift.value = 49.5e-3; },
     [](StepFigures& f) { f.lift.value = 49.3e-3; }},
    {"ThinShellBelowTheContact", "thin_shell", Severity::warning,
     [](StepFigures& f) { f.least_shell.value = 4.9e-3; },
     [](StepFigures& f) {
       f.least_shell.value = 5e-3;
       f.entry_shell = 8e-3;
     }},
    {"ThinShellThatTheWallCarries", "thin_shell", Severity::warning,
     [](StepFigures& f) { f.least_shell.value = 0.0; },
     [](StepFigures& f) {
       f.least_shell.value = 0.0;
       f.left_contact = false;
     }},
    {"FrozenMeniscus", "freezes_at_meniscus", Severity::warning,
     [](StepFigures& f) { f.shell_begins.value = 4.9e-3; },
     [](StepFigures& f) { f.shell_begins.value = 5e-3; }},
    {"ShellThatMeltsInTheGap", "remelting_in_gap", Severity::warning,
     [](StepFigures& f) { f.least_shell.value = 11.9e-3; },  // 60 % of 20 mm
     [](StepFigures& f) { f.least_shell.value = 12.1e-3; }},
    {"StretchedMush", "hot_tears", Severity::warning,
     [](StepFigures& f) {
       f.last = true;
       f.tears.strain_rate.overall = 0.19e-3;
     },
     [](StepFigures& f) {
       f.last = true;
       f.tears.strain_rate = {0.18e-3, 1e-3, 1e-3};
     }},
    {"StretchedMushBeforeTheEnd", "hot_tears", Severity::warning,
     [](StepFigures& f) {
       f.last = true;
       f.tears.strain_rate.overall = 0.19e-3;
     },
     [](StepFigures& f) { f.tears.strain_rate.overall = 0.19e-3; }},
    {"MushThatIsNotFed", "hot_tears", Severity::warning,
     [](StepFigures& f) {
       f.last = true;
       f.tears.pressure.overall = 86e3;
     },
     [](StepFigures& f) {
       f.last = true;
       f.tears.pressure.overall = 85e3;
     }},
    {"MushWithoutMechanics", "hot_tears", Severity::warning,
     [](StepFigures& f) {
       f.last = true;
       f.tears.pressure.overall = 86e3;
     },
     [](StepFigures& f) {
       f.last = true;
       f.mechanical = false;
       f.tears.pressure.overall = 86e3;
     }},
    {"StrainOfTheWorstElement", "hot_tears", Severity::warning,
     [](StepFigures& f) { f.mush_strain.value = 5.1e-3; },
     [](StepFigures& f) { f.mush_strain.value = 5e-3; }},
    {"CurlAboveTheBand", "curl_outside_band", Severity::warning,
     [](StepFigures& f) { f.greatest_curl = 45.1e-3; },
     [](StepFigures& f) { f.greatest_curl = 45e-3; }},
    {"CurlBelowTheBandAtTheEnd", "curl_outside_band", Severity::warning,
     [](StepFigures& f) {
       f.greatest_curl = 4.9e-3;
       f.last = true;
     },
     [](StepFigures& f) { f.greatest_curl = 4.9e-3; }},
};
INSTANTIATE_TEST_SUITE_P(Findings, OfStep, ::testing::ValuesIn(of_step_rows),
                         [](const auto& row) { return row.param.name; });

/// Without a recipe to compare with, the indices are reported and not judged.
TEST(OfStep, HotTearsAreNotJudgedWithoutAReference) {
  StepFigures f = sound_step();
  f.last = true;
  f.mush_strain.value = 1.0;
  f.tears = {{1.0, 1.0, 1.0}, {1e9, 1e9, 1e9}};

  Case c = small_casting();
  c.plausibility.maximum_mush_strain.reset();
  FindingsState state;
  judge(c, f, state);
  EXPECT_EQ(find(state.raised, "hot_tears"), nullptr);
}

TEST(OfStep, ASoundOneHasNone) {
  FindingsState state;
  EXPECT_TRUE(judge(with_band(), sound_step(), state).empty());
  EXPECT_TRUE(state.raised.empty());
}

TEST(OfStep, EachCodeIsRaisedOnceWithItsFirstExceedanceAndItsWorst) {
  FindingsState state;
  StepFigures f = sound_step();
  for (const auto& [time, shell] : {std::pair{12.5, 4e-3}, {13.0, 1e-3}, {14.0, 3e-3}}) {
    f.time = time;
    f.exit_shell = {shell, {0.28 - shell, 0.1}};
    judge(small_casting(), f, state);
  }

  ASSERT_EQ(state.raised.size(), 1u);
  const Finding& raised = state.raised[0];
  EXPECT_EQ(raised.time, 12.5);
  EXPECT_EQ(raised.value, 4e-3);
  EXPECT_EQ(raised.place, (std::vector{0.276, 0.1}));
  EXPECT_EQ(raised.worst, (results::Exceedance{13.0, 1e-3, {0.28 - 1e-3, 0.1}}));
}

/// Two rows of a code have different units: the worst exceedance is that of the row that raised it.
TEST(OfStep, TheWorstIsInTheUnitOfTheFirst) {
  FindingsState state;
  StepFigures f = sound_step();
  f.exit_shell.value = 4e-3;
  judge(small_casting(), f, state);

  f.exit_surface.value = 640.0;
  f.exit_shell.value = 0.0;
  judge(small_casting(), f, state);

  ASSERT_EQ(state.raised.size(), 1u);
  EXPECT_EQ(state.raised[0].unit, "m");
  EXPECT_EQ(state.raised[0].worst->value, 0.0);
}

TEST(OfStep, NoneBeforeTheBlockMoves) {
  FindingsState state;
  StepFigures f = sound_step();
  f.moves = false;
  f.exit_shell.value = f.bottom_shell.value = 0.0;
  f.exit_surface.value = 640.0;
  f.sump_depth = f.metal_depth;

  judge(small_casting(), f, state);
  EXPECT_TRUE(state.raised.empty());
}

TEST(OfStep, AFailureNamesItsFinding) {
  StepFigures f = sound_step();
  f.time_step = 0.5;
  f.slip = {0.03, {0.2, 0.0}};
  f.complementarity_error = 0.1;

  FindingsState state;
  const RunFailures failures = judge(with_band(), f, state);
  ASSERT_EQ(failures.size(), 2u);
  EXPECT_EQ(failures[0].kind, FailureKind::check_failed);
  EXPECT_EQ(failures[0].finding, "contact_violated");

  EXPECT_EQ(failures[1].kind, FailureKind::motion_too_large);
  EXPECT_EQ(failures[1].finding, "slip_too_large");
  EXPECT_EQ(failures[1].time, 12.5);
  EXPECT_EQ(failures[1].time_step, 0.5);
  EXPECT_EQ(failures[1].place, (std::vector{0.2, 0.0}));

  ASSERT_TRUE(state.lost);
  EXPECT_EQ(state.lost->message, failures[1].message);
  EXPECT_TRUE(judge(with_band(), f, state).empty()) << "once is enough";
}

/// Later losses are findings too, but the first one is the loss.
TEST(OfStep, ALossThatTheRunOutlivesFailsNothing) {
  Case c = with_band();
  c.validity.when_lost = WhenLost::go_on;
  StepFigures f = sound_step();
  f.slip.value = 0.03;
  FindingsState state;
  EXPECT_TRUE(judge(c, f, state).empty());

  f.closed_shell = {0.0, {0.1, 0.0}};
  EXPECT_TRUE(judge(c, f, state).empty());
  EXPECT_EQ(state.lost->kind, "motion_too_large");
  EXPECT_NE(find(state.raised, "shell_melted_through"), nullptr);
}

TEST(OfStep, RotationThatElementsFollowIsAWarningBeyondFifteenDegrees) {
  Case c = with_band();
  c.mechanics.options.kinematics = mechanics::Kinematics::corotational;
  StepFigures f = sound_step();

  FindingsState state;
  f.rotation.value = 0.261;  // 14.95 degrees, where small strains are lost
  EXPECT_TRUE(judge(c, f, state).empty());
  EXPECT_EQ(find(state.raised, "rotation_too_large"), nullptr);

  f.rotation.value = 0.263;  // 15.07 degrees
  EXPECT_TRUE(judge(c, f, state).empty());
  EXPECT_FALSE(state.lost);
  EXPECT_EQ(find(state.raised, "rotation_too_large")->severity, Severity::warning);
}

/// The case says how far mesh and steps may have put the shell over the block off.
TEST(OfStep, AFigureWithinItsErrorOfTheLimitIsOpen) {
  Case c = with_band();
  c.figure_errors["shell over the block"] = {.below = 0.6e-3, .above = 0.4e-3};
  StepFigures f = sound_step();
  f.gap_under_shell = 1e-3;
  FindingsState state;
  const auto after = [&](double shell) {
    f.bottom_shell.value = shell;
    judge(c, f, state);
    return find(state.raised, "bleed_out_at_bottom");
  };

  EXPECT_EQ(after(5.7e-3), nullptr);
  const Finding* finding = after(5.5e-3);
  ASSERT_NE(finding, nullptr);
  EXPECT_EQ(finding->severity, Severity::danger);
  EXPECT_EQ(finding->certainty, results::Certainty::open);
  EXPECT_EQ(finding->message,
            "Cannot be told: the shell over the block is 5.5 mm, mesh and steps leave 4.9 mm to "
            "5.9 mm, the limit is 5 mm.");

  EXPECT_THAT(after(5.2e-3)->message,
              ::testing::HasSubstr("is 5.2 mm, mesh and steps leave 4.6 mm to 5.6 mm"));
  EXPECT_THAT(after(5.4e-3)->message, ::testing::HasSubstr("is 5.2 mm"));

  EXPECT_EQ(after(4.8e-3)->certainty, results::Certainty::likely);
  EXPECT_THAT(find(state.raised, "bleed_out_at_bottom")->message,
              ::testing::EndsWith("Likely, not sure: mesh and steps leave 4.2 mm to 5.2 mm."));
  EXPECT_EQ(after(4.5e-3)->certainty, results::Certainty::sure);
  EXPECT_EQ(after(5.2e-3)->certainty, results::Certainty::sure);
  finding = find(state.raised, "bleed_out_at_bottom");
  EXPECT_EQ(finding->worst->value, 4.5e-3);
  EXPECT_NEAR(*finding->lower_error, 0.6e-3, 1e-12);
  EXPECT_NEAR(*finding->upper_error, 0.4e-3, 1e-12);
}

/// What is sure does not hide behind an open figure of the same code.
TEST(OfStep, ASurerFigureReplacesAnOpenOne) {
  Case c = with_band();
  c.figure_errors["surface at the mould exit"] = {.below = 5.0, .above = 5.0};
  StepFigures f = sound_step();
  FindingsState state;
  f.exit_surface.value = 617.0;
  judge(c, f, state);
  EXPECT_EQ(find(state.raised, "bleed_out_at_exit")->certainty, results::Certainty::open);

  c.figure_errors["shell at the mould exit"] = {.below = 0.1, .above = 0.1, .is_relative = true};
  f.exit_shell.value = 2e-3;
  judge(c, f, state);
  const Finding* finding = find(state.raised, "bleed_out_at_exit");
  EXPECT_EQ(finding->certainty, results::Certainty::sure);
  EXPECT_EQ(finding->key, "plausibility.minimum_shell");
  EXPECT_NEAR(*finding->upper_error, 0.2e-3, 1e-12);
}

/// The margin to a limit is known also where nothing is found.
TEST(OfStep, MarginsAreThoseNearestToTheLimits) {
  const Case c = with_band();
  StepFigures f = sound_step();
  f.gap_under_shell = 1e-3;
  FindingsState state;
  for (const double shell : {20e-3, 16e-3, 18e-3}) {
    f.bottom_shell.value = shell;
    judge(c, f, state);
  }
  const auto margin = std::ranges::find(state.margins, "bleed_out_at_bottom", &Margin::code);
  ASSERT_NE(margin, state.margins.end());
  EXPECT_EQ(margin->worst.value, 16e-3);
  EXPECT_EQ(margin->limit, 5e-3);
  EXPECT_TRUE(state.raised.empty());
}

/// A figure that is not a number violates its check, and is left out of the finding.
TEST(OfStep, AFigureThatIsNoNumberFailsItsCheck) {
  StepFigures f = sound_step();
  f.energy_balance_error = std::nan("");
  FindingsState state;
  ASSERT_EQ(judge(with_band(), f, state).size(), 1u);
  EXPECT_FALSE(state.raised[0].value);
  EXPECT_FALSE(state.raised[0].worst);
}

/// docs/findings.md has a row for every code, and the rows of a code differ in their key.
TEST(Rules, AreDocumentedAndDistinct) {
  const std::string page = bytes_of(DCCAST_DOCS "/findings.md");
  std::set<std::pair<std::string, std::string>> rows;
  for (const StepRule& rule : step_rules()) {
    EXPECT_THAT(page, ::testing::HasSubstr("| `" + std::string(rule.code) + "` |"));
    const std::string consequence = rule.consequence ? name_of(*rule.consequence) : "";
    EXPECT_TRUE(rows.insert({rule.code, rule.key + consequence}).second) << rule.code;
  }
  for (const CaseRule& rule : case_rules())
    EXPECT_THAT(page, ::testing::HasSubstr("| `" + std::string(rule.code) + "` |"));
}

TEST(FindingsState, ComesBackFromACheckpoint) {
  FindingsState state;
  state.history = {.shell_stood = true,
                   .when_liquid = {0.5, 1.0},
                   .thickest_bottom_shell = 1.0 / 3.0,
                   .wall_force = 5.0,
                   .passages = {{625.0, 1e-3, 2.5, {0.1, 0.2, 0.3}}, {}},
                   .tears = {{1.0, 2.0, 3.0}, {4.0, 5.0, 6.0}},
                   .pore_volume = 0.7};
  state.lost = {"motion_too_large", "it slid", 12.5, {0.1, 0.2}, 0.03, 0.02, "m"};
  state.raised = {{"no_superheat", Severity::danger, "Cold.", {}, {}, -20.0, 5.0, "K", "a.key"},
                  {"hot_tears", Severity::note, "Tears.", 12.5, {0.1, 0.2}, {}, {}, "", ""},
                  {"slip_too_large",
                   Severity::danger,
                   "Slid.",
                   12.5,
                   {0.1, 0.2},
                   0.03,
                   0.02,
                   "m",
                   "a.key",
                   results::Exceedance{13.0, 0.04, {0.2, 0.0}},
                   results::Certainty::likely,
                   0.01,
                   0.03}};
  state.margins = {{"slip_too_large", "a.key", "m", 0.02, {13.0, 0.04, {0.2, 0.0}}}};

  results::Sections sections;
  write_findings(state, sections);
  const auto decoded = results::decode(results::encode(sections));
  ASSERT_TRUE(decoded);

  const FindingsState back = read_findings(*decoded);
  EXPECT_EQ(back.raised, state.raised);
  EXPECT_EQ(back.margins, state.margins);
  EXPECT_EQ(back.lost, state.lost);
  EXPECT_EQ(back.history.shell_stood, true);
  EXPECT_EQ(back.history.when_liquid, state.history.when_liquid);
  EXPECT_EQ(back.history.thickest_bottom_shell, state.history.thickest_bottom_shell);
  EXPECT_EQ(back.history.wall_force, 5.0);
  ASSERT_EQ(back.history.passages.size(), 2u);
  EXPECT_EQ(back.history.passages[0].time, 2.5);
  EXPECT_EQ(back.history.passages[0].feeding.shrunk, 0.3);
  EXPECT_EQ(back.history.tears.strain_rate.centre, 2.0);
  EXPECT_EQ(back.history.tears.pressure.surface, 6.0);
  EXPECT_EQ(back.history.pore_volume, 0.7);
}

class Recorder : public testing::Recorder {
public:
  std::vector<Finding> findings;  ///< the last one of each code, as in the results
  int times = 0;

  void on_finding(const Finding& finding) override {
    ++times;
    const auto known = std::ranges::find(findings, finding.code, &Finding::code);
    if (known == findings.end())
      findings.push_back(finding);
    else
      *known = finding;
  }
};

/// A casting without water, so fast that nothing freezes in the mould.
Case hopeless() {
  Case c = small_casting(mesh::ElementKind::q1);
  c.validity.when_lost = WhenLost::go_on;
  c.cooling.water.enabled = false;
  c.schedule.casting_speed = Curve(4e-3);
  c.schedule.casting_temperature = Curve(650.0);
  return c;
}

TEST(FindingsOfARun, AreReportedAndKeptInTheResults) {
  const TemporaryFolder folder;
  Recorder recorder;
  EXPECT_EQ(run(hopeless(), {folder / "", false}, recorder).end, RunEnd::succeeded);

  for (const char* code : {"no_superheat", "water_never_meets", "bleed_out_at_exit"})
    EXPECT_NE(find(recorder.findings, code), nullptr) << code;
  EXPECT_LE(std::size_t(recorder.times), 2 * recorder.findings.size())
      << "when it is raised, and at the end with its worst exceedance";
  EXPECT_EQ(results::ResultReader(folder / "results.h5").summary().findings, recorder.findings);
}

/// A stop before and after the step of each finding: all are reported again, none changes.
TEST(FindingsOfARun, AreTheSameAfterAResumption) {
  const TemporaryFolder whole;
  Recorder uninterrupted;
  EXPECT_EQ(run(hopeless(), {whole / "", false}, uninterrupted).end, RunEnd::succeeded);

  for (const std::int64_t stop : {3, 15, 30}) {
    const TemporaryFolder folder;
    Recorder first, second;
    first.act_after = stop;
    first.then = Order::stop_at_checkpoint;
    ASSERT_EQ(run(hopeless(), {folder / "", false}, first).end, RunEnd::stopped);

    second.before = first.reports;
    EXPECT_EQ(run(hopeless(), {folder / "", true}, second).end, RunEnd::succeeded);

    EXPECT_EQ(second.resumed_from, stop);
    EXPECT_EQ(second.findings, uninterrupted.findings);
    EXPECT_TRUE(bytes_of(folder / "results.h5") == bytes_of(whole / "results.h5")) << stop;
  }
}

/// The coarse run has not the errors of the case's own mesh.
TEST(Forecast, IsJudgedWithoutTheErrorsOfTheCase) {
  Case c = hopeless();
  const auto without = forecast(c);
  for (const char* figure : {"shell at the mould exit", "surface at the mould exit"})
    c.figure_errors[figure] = {.below = 0.9, .above = 10.0, .is_relative = true};
  EXPECT_EQ(forecast(c), without);
}

TEST(Forecast, OfAnImportedMeshOrGivenTemperaturesThereIsNone) {
  Case c = hopeless();
  EXPECT_FALSE(forecast(c).empty());
  for (const Finding& finding : forecast(c))
    EXPECT_FALSE(finding.key.empty()) << finding.code << ": the coarse run is judged, not the case";

  c.section.file = "mesh.msh";
  EXPECT_TRUE(forecast(c).empty());

  c = hopeless();
  c.thermal.file = "temperature.h5";
  EXPECT_TRUE(forecast(c).empty());
}

}  // namespace
}  // namespace dccast::casting
