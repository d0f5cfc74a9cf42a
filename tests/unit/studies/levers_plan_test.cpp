#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schedule.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

v1::CreateStudyRequest levers() {
  v1::CreateStudyRequest request;
  const auto* const shipped = shipped::find(shipped::case_templates(), "start-2d-thickness");
  EXPECT_TRUE(case_file::read_text(shipped->text, shipped->name, *request.mutable_case_()).ok());
  request.mutable_case_()->set_quality(v1::DRAFT);
  case_file::apply_defaults(*request.mutable_case_());
  request.mutable_levers();
  return request;
}

/// A casting whose curl and shell depend on the cast length alone: that of another speed is the
/// same butt, cast later.
EvaluatedRun cast_at(int number, double speed_m_per_s, double more_curl_m = 0.0) {
  constexpr double length_m = 0.12;
  EvaluatedRun run;
  run.number = number;
  run.run.set_state(v1::SUCCEEDED);
  v1::CurlCurve& curve = run.history.curves.emplace_back();
  curve.set_monitor("corner");
  for (int step = -10; step <= 1000; ++step) {
    const double time_s = step * length_m / 1000.0 / speed_m_per_s;
    const double cast_m = std::max(0.0, speed_m_per_s * time_s);
    curve.add_time_s(time_s);
    curve.add_cast_length_m(cast_m);
    curve.add_curl_m(step <= 0 ? NAN : 0.2 * cast_m + more_curl_m * cast_m / length_m);
    run.history.least_shell_m.push_back(step <= 0 ? 0.0 : 0.02 - 0.05 * cast_m);
  }
  return run;
}

/// The plan with its runs as they are evaluated: the description of each by the plan.
v1::StudyResult evaluated(std::vector<EvaluatedRun> runs) {
  const auto plan = study_plan(levers());
  v1::StudyResult result;
  for (EvaluatedRun& run : runs) plan->describe(run.number, run.run);
  plan->evaluate(runs, result);
  return result;
}

/// By monitor of the case.
double corner_m(const v1::LeverEffect& effect) {
  const auto request = levers();
  for (int i = 0; i < request.case_().monitor_size(); ++i)
    if (request.case_().monitor(i).name() == "corner") return effect.curl_m(i);
  return NAN;
}

v1::Finding finding(const std::string& code, double value, v1::Finding::Severity severity) {
  v1::Finding finding;
  finding.set_code(code);
  finding.set_severity(severity);
  finding.set_value(value);
  finding.set_limit(10e-3);
  return finding;
}

/// Runs of one casting: the plan, and six levers from two times on.
constexpr int runs_of_one = 13;

TEST(LeversPlan, IsEightCastingsEachWithItsLevers) {
  const auto plan = study_plan(levers());
  ASSERT_EQ(plan->runs(), 8 * runs_of_one);
  EXPECT_EQ(plan->run(0).name, "the plan");
  EXPECT_EQ(plan->run(1).name, "cast 10 % slower");
  EXPECT_GT(plan->run(1).description.time().end_s(), plan->run(0).description.time().end_s());
  EXPECT_THAT(plan->run(0).description.uncertainty(), IsEmpty());
  EXPECT_THAT(plan_faults(levers()), IsEmpty());

  v1::StudyRun run;
  plan->describe(runs_of_one + 7, run);
  EXPECT_EQ(run.lever_step().from_s(), 36.3) << "of 145 s";
}

/// A lever is moved in the casting of the same data. The metal temperature is both a lever and
/// uncertain.
TEST(LeversPlan, MovesALeverInTheCastingOfTheSameData) {
  const auto plan = study_plan(levers());
  const auto metal_c = [&](int number, double time_s) {
    return case_file::curve_value(plan->run(number).description.schedule().casting_temperature_c(),
                                  time_s);
  };
  for (const int member : {0, 1}) {
    const int first = member * runs_of_one;
    const double planned_c = metal_c(first, 0.0);
    EXPECT_NE(planned_c, 680.0);
    EXPECT_DOUBLE_EQ(metal_c(first + 5, 14.0), planned_c);
    EXPECT_DOUBLE_EQ(metal_c(first + 5, 15.0), planned_c - 10.0);
  }
  EXPECT_NE(metal_c(0, 0.0), metal_c(runs_of_one, 0.0));
}

/// Slowing only delays the curl: at equal cast length nothing is gained.
TEST(LeversPlan, ACastingThatIsOnlySlowerOrFasterHasNoGain) {
  const v1::StudyResult result =
      evaluated({cast_at(0, 1e-3), cast_at(1, 0.9e-3), cast_at(2, 1.1e-3)});
  ASSERT_THAT(result.lever_effects(), SizeIs(3));
  EXPECT_NEAR(corner_m(result.lever_effects(0)), 0.2 * 0.12, 1e-9) << "the plan itself";
  for (const int each : {1, 2}) {
    const v1::LeverEffect& effect = result.lever_effects(each);
    EXPECT_NEAR(corner_m(effect), 0.0, 1e-9);
    EXPECT_NEAR(effect.least_shell_m(), 0.0, 1e-9);
    EXPECT_THAT(effect.worse(), IsEmpty());
  }
}

/// A tenth of a second more is no gain or loss: both count where the shorter one ends.
TEST(LeversPlan, RunsOfUnequalLengthCountWhereTheShorterOneEnds) {
  EvaluatedRun shorter = cast_at(2, 1e-3, -2e-3);
  v1::CurlCurve& curve = shorter.history.curves.front();
  for (auto* const values :
       {curve.mutable_time_s(), curve.mutable_cast_length_m(), curve.mutable_curl_m()})
    values->Truncate(511);  // 60 mm
  shorter.history.least_shell_m.resize(511);
  const v1::StudyResult result = evaluated({cast_at(0, 1e-3), shorter});
  ASSERT_THAT(result.lever_effects(), SizeIs(2));
  EXPECT_NEAR(corner_m(result.lever_effects(1)), -1e-3, 1e-9);
}

TEST(LeversPlan, FindingsThatAreNewOrFartherBeyondTheirLimitAreWorse) {
  EvaluatedRun base = cast_at(0, 1e-3), same = cast_at(1, 1e-3), worse = cast_at(2, 1e-3);
  *base.run.add_findings() = finding("thin_shell", 8e-3, v1::Finding::WARNING);
  *same.run.add_findings() = finding("thin_shell", 7.9e-3, v1::Finding::WARNING);
  *same.run.add_findings() = finding("no_superheat", 1.0, v1::Finding::NOTE);
  *worse.run.add_findings() = finding("thin_shell", 7e-3, v1::Finding::WARNING);
  *worse.run.add_findings() = finding("water_thrown_off", 1.0, v1::Finding::DANGER);

  const v1::StudyResult result = evaluated({base, same, worse});
  EXPECT_THAT(result.lever_effects(1).worse(), IsEmpty());
  EXPECT_THAT(result.lever_effects(2).worse(), ElementsAre("thin_shell", "water_thrown_off"));
}

TEST(LeversPlan, ARunThatFailedHasNoEffectAndItsReason) {
  EvaluatedRun failed = cast_at(1, 1e-3);
  failed.run.set_state(v1::FAILED);
  failed.run.mutable_failure()->set_code("shell_melted_through");
  const v1::StudyResult result = evaluated({cast_at(0, 1e-3), failed});
  EXPECT_TRUE(std::isnan(corner_m(result.lever_effects(1))));
  EXPECT_THAT(result.lever_effects(1).worse(), ElementsAre("shell_melted_through"));
}

TEST(LeversPlan, WithoutItsPlanACastingHasNothingToCompareWith) {
  EvaluatedRun failed = cast_at(0, 1e-3);
  failed.run.set_state(v1::FAILED);
  EXPECT_THAT(evaluated({failed, cast_at(1, 1e-3)}).lever_effects(), IsEmpty());
  EXPECT_THAT(evaluated({cast_at(0, 1e-3), cast_at(runs_of_one + 1, 1e-3)}).lever_effects(),
              SizeIs(1))
      << "the plan of other data";
}

}  // namespace
}  // namespace dccast::studies
