#include <algorithm>
#include <set>
#include <string>
#include <tuple>

#include "core/casting/findings/judge.hpp"
#include "core/casting/forecast.hpp"
#include "core/casting/simulation.hpp"
#include "tests/regression/whole_run.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

using Codes = std::set<std::string>;

struct Recorder : regression::Recorder {
  std::vector<results::Finding> findings;
  void on_finding(const results::Finding& finding) override { findings.push_back(finding); }
};

Codes codes_of(const std::vector<results::Finding>& findings) {
  Codes codes;
  for (const auto& finding : findings) codes.insert(finding.code);
  return codes;
}

std::vector<results::Finding> findings_of(const casting::Case& c) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("dccast-impossible-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  Recorder recorder;
  std::ignore = casting::run(c, {folder, false}, recorder);  // however it ends
  std::filesystem::remove_all(folder);
  return recorder.findings;
}

double time_of(const std::vector<results::Finding>& findings, const std::string& code) {
  const auto found = std::ranges::find(findings, code, &results::Finding::code);
  return found == findings.end() ? NAN : found->time.value_or(NAN);
}

TEST(ImpossibleCasting, TheShippedOneIsNone) {
  const casting::Case c = support::load_case("start-2d-thickness");
  EXPECT_EQ(codes_of(findings_of(c)), Codes{});
  EXPECT_EQ(codes_of(casting::findings_of_case(c)), Codes{});
  EXPECT_EQ(codes_of(casting::forecast(c)), Codes{});
}

TEST(ImpossibleCasting, ColderThanItsSolidusIsTold) {
  casting::Case c = support::load_case("start-2d-thickness");
  c.schedule.casting_temperature = Curve(600.0);
  const auto findings = casting::findings_of_case(c);
  ASSERT_TRUE(codes_of(findings).contains("no_superheat"));
  EXPECT_EQ(findings[0].severity, results::Severity::danger);
}

TEST(ImpossibleCasting, WithoutWaterItBleedsAtTheMouldExit) {
  casting::Case c = support::load_case("start-2d-thickness");
  c.cooling.water.enabled = false;
  Codes codes = codes_of(findings_of(c));
  for (const char* code : {"water_never_meets", "bleed_out_at_exit"})
    EXPECT_TRUE(codes.contains(code)) << code;
  c.cooling.top = thermal::Top::held;
  c.alloy.shell = c.alloy.solidus;
  codes = codes_of(findings_of(c));
  for (const char* code : {"bleed_out_at_bottom", "level_overheats"})
    EXPECT_TRUE(codes.contains(code)) << code;
  c.cooling.top = thermal::Top::pouring;
  EXPECT_TRUE(codes_of(casting::forecast(c)).contains("bleed_out_at_exit"));
}

TEST(ImpossibleCasting, At400MillimetresAMinuteItHasNoShell) {
  casting::Case c = support::load_case("start-2d-thickness");
  c.schedule.casting_speed = Curve(0.4 / 60.0);
  const Codes codes = codes_of(findings_of(c));
  for (const char* code : {"bleed_out_at_exit", "sump_too_deep"})
    EXPECT_TRUE(codes.contains(code)) << code;
  EXPECT_TRUE(codes_of(casting::forecast(c)).contains("bleed_out_at_exit"));
}

/// A held level melts the shell of the long section; findings warn of its end before it comes.
TEST(ImpossibleCasting, TheLongSectionWarnsBeforeItsShellIsCut) {
  casting::Case c = support::load_case("start-2d-long");
  c.cooling.top = thermal::Top::held;
  c.cooling.water.boiling_follows_flow = false;
  c.alloy.shell = c.alloy.solidus;
  const auto findings = findings_of(c);
  const double cut = time_of(findings, "shell_melted_through");
  EXPECT_NEAR(cut, 166.0, 5.0);
  EXPECT_LT(time_of(findings, "bottom_shell_fails"), cut - 60.0);
  EXPECT_LT(time_of(findings, "bleed_out_at_bottom"), cut - 20.0);
}

TEST(ImpossibleCasting, ABilletWithoutAHoldOpensAtItsAxisOnTheBlockFirst) {
  casting::Case c = support::load_case("start-billet");
  c.schedule.hold = 4.0;
  c.schedule.filling = 0.0;
  const auto findings = findings_of(c);
  EXPECT_LT(time_of(findings, "bottom_shell_open"), 10.0);
  EXPECT_LE(time_of(findings, "bottom_shell_open"), time_of(findings, "sump_too_deep"));
}

}  // namespace
}  // namespace dccast
