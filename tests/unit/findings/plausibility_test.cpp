#include "core/findings/plausibility.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <ostream>

#include "core/casting/forecast.hpp"
#include "core/findings/of_step.hpp"
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

void expect_complete(const Finding& finding) {
  EXPECT_FALSE(finding.key.empty());
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

void mush_of_5182(Case& c, double coherency) {
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
    {"CoherencyOfAnotherCard", "coherency_in_liquid", [](Case& c) { mush_of_5182(c, 620.0); },
     [](Case& c) { mush_of_5182(c, 576.0); }},
    {"CoherencyBelowTheSolidus", "coherency_in_liquid", [](Case& c) { mush_of_5182(c, 514.0); },
     [](Case& c) { mush_of_5182(c, 515.0); }},
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

/// Of the small casting, with nothing to be found.
StepFigures sound_step() {
  StepFigures f;
  f.time = 12.5;
  f.moves = f.mechanical = f.left_mould = f.in_gap = true;
  f.metal_depth = 0.2;
  f.sump_depth = 0.1;
  f.exit_surface = {400.0, {0.28, 0.1}};
  f.exit_shell = {0.04, {0.24, 0.1}};
  f.gap_entry = 600.0;
  f.gap_surface = {590.0, {0.28, 0.12}};
  f.bottom_shell = {0.03, {0.1, 0.0}};
  f.thickest_bottom_shell = 0.035;
  f.lift = {0.01, {0.28, 0.0}};
  f.greatest_curl = 0.01;
  return f;
}

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
  c.plausibility.least_curl = 0.005;
  c.plausibility.greatest_curl = 0.045;
  return c;
}

class OfStep : public ::testing::TestWithParam<StepRow> {};

TEST_P(OfStep, IsRaisedBeyondItsLimitAndJustNotAtIt) {
  const StepRow& row = GetParam();
  StepFigures beyond = sound_step(), within = sound_step();
  row.raises(beyond);
  row.does_not(within);
  PlausibilityState state, none;
  raise_findings(with_band(), beyond, state);
  const Finding* raised = find(state.raised, row.code);
  ASSERT_NE(raised, nullptr);
  EXPECT_EQ(raised->time, 12.5);
  EXPECT_EQ(raised->severity, row.severity);
  expect_complete(*raised);
  raise_findings(with_band(), within, none);
  EXPECT_EQ(find(none.raised, row.code), nullptr);
}

std::optional<results::ValidityLoss> lost(FailureKind kind) {
  results::ValidityLoss loss;
  loss.kind = name_of(kind);
  loss.unit = "m";
  return loss;
}

const StepRow of_step_rows[] = {
    {"SurfaceAboveTheSolidus", "bleed_out_at_exit", Severity::danger,
     [](StepFigures& f) { f.exit_surface.value = 620.0; },
     [](StepFigures& f) { f.exit_surface.value = 619.9; }},
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
     [](StepFigures& f) { f.gap_surface.value = 620.0; },
     [](StepFigures& f) { f.gap_surface.value = 619.9; }},
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
    {"DeepSump", "sump_too_deep", Severity::danger, [](StepFigures& f) { f.sump_depth = 0.1901; },
     [](StepFigures& f) { f.sump_depth = 0.1899; }},
    {"MeltedShell", "shell_melted_through", Severity::danger,
     [](StepFigures& f) { f.validity_lost = lost(FailureKind::shell_melted_through); },
     [](StepFigures& f) { f.validity_lost = lost(FailureKind::liquid_pressure_lost); }},
    {"LiquidPressure", "liquid_pressure_lost", Severity::danger,
     [](StepFigures& f) { f.validity_lost = lost(FailureKind::liquid_pressure_lost); },
     [](StepFigures&) {}},
    {"Slip", "slip_too_large", Severity::danger, [](StepFigures& f) { f.slip = 20.1e-3; },
     [](StepFigures& f) { f.slip = 19.9e-3; }},
    {"Rotation", "rotation_too_large", Severity::danger, [](StepFigures& f) { f.rotation = 0.175; },
     [](StepFigures& f) { f.rotation = 0.174; }},
    {"Lift", "lift_too_large", Severity::danger,  // 0.28 m times tan 10 degrees is 49.4 mm
     [](StepFigures& f) { f.lift.value = 49.5e-3; },
     [](StepFigures& f) { f.lift.value = 49.3e-3; }},
    {"HotTears", "hot_tears", Severity::warning,
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

TEST(OfStep, ASoundOneHasNone) {
  PlausibilityState state;
  raise_findings(with_band(), sound_step(), state);
  EXPECT_TRUE(state.raised.empty());
}

TEST(OfStep, EachCodeIsRaisedOnceWithItsFirstTimeAndPlace) {
  PlausibilityState state;
  StepFigures f = sound_step();
  f.exit_shell.value = 4e-3;
  raise_findings(small_casting(), f, state);
  f.time = 13.0;
  f.exit_shell = {1e-3, {0.2, 0.1}};
  raise_findings(small_casting(), f, state);
  ASSERT_EQ(state.raised.size(), 1u);
  EXPECT_EQ(state.raised[0].time, 12.5);
  EXPECT_EQ(state.raised[0].value, 4e-3);
  EXPECT_EQ(state.raised[0].place, (std::vector{0.24, 0.1}));
}

TEST(OfStep, NoneBeforeTheBlockMoves) {
  PlausibilityState state;
  StepFigures f = sound_step();
  f.moves = false;
  f.exit_shell.value = f.bottom_shell.value = 0.0;
  f.exit_surface.value = 640.0;
  f.sump_depth = f.metal_depth;
  raise_findings(small_casting(), f, state);
  EXPECT_TRUE(state.raised.empty());
}

TEST(PlausibilityState, ComesBackFromACheckpoint) {
  PlausibilityState state;
  state.thickest_bottom_shell = 1.0 / 3.0;
  state.raised = {{"no_superheat", Severity::danger, "Cold.", {}, {}, -20.0, 5.0, "K", "a.key"},
                  {"hot_tears", Severity::note, "Tears.", 12.5, {0.1, 0.2}, {}, {}, "", ""}};
  restart::Sections sections;
  write_plausibility(state, sections);
  const auto decoded = restart::decode(restart::encode(sections));
  ASSERT_TRUE(decoded);
  const PlausibilityState back = read_plausibility(*decoded);
  EXPECT_EQ(back.raised, state.raised);
  EXPECT_EQ(back.thickest_bottom_shell, state.thickest_bottom_shell);
}

class Recorder : public testing::Recorder {
public:
  std::vector<Finding> findings;
  void on_finding(const Finding& finding) override { findings.push_back(finding); }
};

/// Without water, cast so fast that nothing freezes in the mould.
Case hopeless() {
  Case c = small_casting(mesh::ElementKind::q1);
  c.validity.when_lost = WhenLost::go_on;
  c.cooling.water.enabled = false;
  c.schedule.casting_speed = Curve(4e-3);
  c.schedule.casting_temperature = Curve(650.0);
  return c;
}

TEST(FindingsOfARun, AreToldWhenTheyComeAndKeptInTheResults) {
  const TemporaryFolder folder;
  Recorder recorder;
  run(hopeless(), {folder / "", false}, recorder);
  for (const char* code : {"no_superheat", "water_never_meets", "bleed_out_at_exit"})
    EXPECT_NE(find(recorder.findings, code), nullptr) << code;
  std::vector<std::string> codes;
  for (const Finding& finding : recorder.findings) codes.push_back(finding.code);
  std::ranges::sort(codes);
  EXPECT_EQ(std::ranges::adjacent_find(codes), codes.end()) << "one of them comes twice";
  EXPECT_EQ(results::ResultReader(folder / "results.h5").summary().findings, recorder.findings);
}

/// A stop before and behind the step of each finding: all are told again, none changes.
TEST(FindingsOfARun, AreTheSameAfterAResumption) {
  const TemporaryFolder whole;
  Recorder uninterrupted;
  run(hopeless(), {whole / "", false}, uninterrupted);
  for (const std::int64_t stop : {3, 15, 30}) {
    const TemporaryFolder folder;
    Recorder first, second;
    first.act_after = stop;
    first.then = Order::stop_at_checkpoint;
    ASSERT_EQ(run(hopeless(), {folder / "", false}, first).end, RunEnd::stopped);
    run(hopeless(), {folder / "", true}, second);
    EXPECT_EQ(second.resumed_from, stop);
    EXPECT_EQ(second.findings, uninterrupted.findings);
    EXPECT_TRUE(bytes_of(folder / "results.h5") == bytes_of(whole / "results.h5")) << stop;
  }
}

TEST(Forecast, OfAnImportedMeshOrGivenTemperaturesThereIsNone) {
  Case c = hopeless();
  EXPECT_FALSE(forecast(c).empty());
  c.section.file = "mesh.msh";
  EXPECT_TRUE(forecast(c).empty());
  c = hopeless();
  c.thermal.file = "temperature.h5";
  EXPECT_TRUE(forecast(c).empty());
}

}  // namespace
}  // namespace dccast::casting
