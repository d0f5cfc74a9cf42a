#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "proto/case_file/recipe_numbers.hpp"
#include "proto/case_file/schedule.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

constexpr double mm_per_min = 1.0 / 60e3;

v1::Case start() {
  v1::Case c;
  c.add_monitor()->set_name("corner");
  v1::Schedule& schedule = *c.mutable_schedule();
  schedule.set_hold_s(60.0);
  schedule.set_filling_s(50.0);
  schedule.mutable_casting_temperature_c()->add_value(680.0);
  v1::Curve& speed = *schedule.mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::TIME);
  for (const auto& [at, value] : {std::pair(60.0, 40.0), std::pair(200.0, 60.0)}) {
    speed.add_at(at);
    speed.add_value(value * mm_per_min);
  }
  c.mutable_time()->set_end_s(250.0);
  return c;
}

v1::CreateStudyRequest request() {
  v1::CreateStudyRequest request;
  *request.mutable_case_() = start();

  v1::RecipePlan& plan = *request.mutable_recipe();
  *plan.mutable_draft() = start();

  const auto add = [&](const char* name, double low, double high) {
    v1::RecipePlan::Number& number = *plan.add_numbers();
    number.set_name(name);
    number.set_low(low);
    number.set_high(high);
  };
  add("speed_start", 30.0 * mm_per_min, 50.0 * mm_per_min);
  add("speed_run", 50.0 * mm_per_min, 70.0 * mm_per_min);
  add("speed_ramp", 30.0, 200.0);
  add("filling", 20.0, 80.0);
  add("hold", 40.0, 80.0);

  v1::RecipePlan::Datum& datum = *plan.add_data();
  datum.set_key("schedule.casting_temperature.offset");
  datum.set_low("-10 K");
  datum.set_high("10 K");

  plan.set_least_curl_m(0.035);
  plan.set_greatest_curl_m(0.045);
  plan.set_greatest_speed_rate_m_per_s2(30.0 * mm_per_min / 60.0);
  plan.set_greatest_flow_rate_m2_per_s2(1e-4);

  plan.set_drafts(60);
  plan.set_castings(6);
  plan.set_candidates(3);
  plan.set_seed(1);
  return request;
}

std::string fields_of(const v1::CreateStudyRequest& request) {
  std::string fields;
  for (const v1::Fault& fault : plan_faults(request)) fields += fault.field() + " ";
  return fields;
}

/// A world in which the curl is 40 mm at a start of 40 mm/min, 2 mm more for each mm/min less and
/// 0.5 mm for each degree of the metal; a hold below 60 s is a danger. Full quality curls a tenth
/// more.
EvaluatedRun cast(const StudyPlan& plan, int number, const PlannedRun& planned) {
  const v1::Schedule& schedule = planned.description.schedule();
  const double speed = schedule.casting_speed_m_per_s().value(0) / mm_per_min;
  const double warmer = schedule.casting_temperature_c().value(0) - 680.0;
  const bool full = number == 1 || (planned.name.starts_with("candidate") &&
                                    planned.name.find("casting") == std::string::npos);
  EvaluatedRun run;
  run.number = number;
  run.run.set_state(v1::SUCCEEDED);
  run.run.add_end_curl_m(1e-3 * (full ? 1.1 : 1.0) * (40.0 + 2.0 * (40.0 - speed) + 0.5 * warmer));
  if (schedule.hold_s() < 60.0) {
    run.run.set_state(v1::FAILED);
    run.run.mutable_failure()->set_kind(v1::Finding::SHELL_MELTED_THROUGH);
    run.run.mutable_failure()->set_code("shell_melted_through");
    run.run.set_end_curl_m(0, std::nan(""));
  }
  plan.describe(number, run.run);
  return run;
}

/// All runs of a plan, as the feeder makes them.
std::vector<EvaluatedRun> cast_all(const StudyPlan& plan,
                                   std::vector<PlannedRun>* planned = nullptr) {
  std::vector<EvaluatedRun> runs;
  for (int number = 0; number < plan.most_runs(); ++number) {
    std::optional<PlannedRun> next;
    if (number < plan.runs()) {
      next = plan.run(number);
    } else {
      const std::vector<EvaluatedRun> before(runs.begin(), runs.begin() + plan.rests_on(number));
      next = plan.next(number, before);
    }
    if (!next) break;
    if (planned != nullptr) planned->push_back(*next);
    runs.push_back(cast(plan, number, *next));
  }
  return runs;
}

v1::RecipeFound found_in(const StudyPlan& plan, const std::vector<EvaluatedRun>& runs) {
  v1::StudyResult result;
  plan.evaluate(runs, result);
  return result.recipe();
}

TEST(RecipePlan, FindsTheRecipeThatIsSafeAndInside) {
  const auto plan = study_plan(request());
  EXPECT_EQ(plan->runs(), 62);
  EXPECT_EQ(plan->most_runs(), 62 + 18 + 3 + 18);

  const auto found = found_in(*plan, cast_all(*plan));
  EXPECT_THAT(found.fault(), IsEmpty());
  EXPECT_EQ(found.monitor(), "corner");
  EXPECT_NEAR(found.full_over_draft(), 1.1, 1e-12);
  EXPECT_LT(found.surface_error_m(), 1e-3);
  ASSERT_GT(found.front_size(), 0);
  ASSERT_GE(found.chosen(), 0);

  const auto& chosen = found.front(found.chosen());
  // 1.1 (40 + 2 (40 - v)) = 40: v = 41.8; the metal makes 5.5 mm to both sides, a tenth of it lost.
  EXPECT_NEAR(chosen.numbers(0) / mm_per_min, 41.8, 1.0);
  EXPECT_GT(chosen.numbers(4), 60.0);
  EXPECT_LE(chosen.numbers(3), chosen.numbers(4)) << "no filling beyond the hold";
  EXPECT_NEAR(chosen.full_curl_m(), 0.04, 2e-3);
  EXPECT_NEAR(chosen.median_m(), 0.04, 2e-3);
  EXPECT_NEAR(chosen.surface_risk(), 0.09, 0.08);
  EXPECT_NEAR(chosen.risk(), 0.09, 2.0 * chosen.risk_error());
  EXPECT_EQ(chosen.castings(), 6);
  EXPECT_GT(chosen.casting_time_s(), 250.0);
  EXPECT_TRUE(found.has_itself());
  EXPECT_GT(found.itself().risk(), chosen.surface_risk()) << "44 mm in the middle";
  for (int i = 1; i < found.front_size(); ++i)
    EXPECT_LE(found.front(i - 1).risk(), found.front(i).risk());
}

TEST(RecipePlan, EveryRunIsInsideTheLimitsOfThePlant) {
  const auto plan = study_plan(request());
  std::vector<PlannedRun> planned;
  cast_all(*plan, &planned);
  const double length = case_file::CastingSchedule(start()).cast_length_at_end_m();
  for (const PlannedRun& run : planned) {
    const auto recipe = case_file::recipe_of(run.description);
    const double rate = std::abs(recipe[case_file::speed_run] - recipe[case_file::speed_start]) /
                        recipe[case_file::speed_ramp];
    EXPECT_LE(rate, 1.001 * request().recipe().greatest_speed_rate_m_per_s2()) << run.name;
    EXPECT_GE(recipe[case_file::speed_start], 29.99 * mm_per_min) << run.name;
    EXPECT_LE(recipe[case_file::filling], recipe[case_file::hold] + 0.01) << run.name;
    EXPECT_NEAR(case_file::CastingSchedule(run.description).cast_length_at_end_m(), length, 2e-4)
        << run.name;
  }
}

TEST(RecipePlan, TheSameRequestMakesTheSameRunsWhoeverAsks) {
  std::vector<PlannedRun> first, second;
  const auto plan = study_plan(request()), again = study_plan(request());
  const auto found = found_in(*plan, cast_all(*plan, &first));
  cast_all(*again, &second);

  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].key, second[i].key);
    EXPECT_EQ(first[i].description.SerializeAsString(), second[i].description.SerializeAsString());
  }

  // A daemon that comes back has the runs and none of what was found before.
  const auto restarted = study_plan(request());
  EXPECT_EQ(found_in(*restarted, cast_all(*plan)).SerializeAsString(), found.SerializeAsString());

  auto other = request();
  other.mutable_recipe()->set_seed(2);
  EXPECT_NE(study_plan(other)->run(2).description.SerializeAsString(),
            first[2].description.SerializeAsString());
}

TEST(RecipePlan, CandidatesWaitForTheRunsTheyRestOn) {
  const auto plan = study_plan(request());
  EXPECT_EQ(plan->rests_on(plan->runs()), plan->runs());
  EXPECT_EQ(plan->rests_on(plan->runs() + 17), plan->runs());
  EXPECT_EQ(plan->rests_on(plan->runs() + 18), plan->runs() + 18);

  auto runs = cast_all(*plan);
  runs.resize(static_cast<std::size_t>(plan->runs()));
  runs.back().run.set_state(v1::RUNNING);
  const auto fresh = study_plan(request());
  EXPECT_FALSE(fresh->next(fresh->runs(), runs));
  EXPECT_THAT(found_in(*fresh, runs).fault(), HasSubstr("not all ended"));
  EXPECT_TRUE(fresh->outlasts_failures());

  runs.back().run.set_state(v1::FAILED);
  runs.back().run.mutable_failure()->set_kind(v1::Finding::WORKER_LOST);
  EXPECT_FALSE(fresh->next(fresh->runs(), runs)) << "once it has run there may be other candidates";

  runs.back().run.mutable_failure()->set_kind(v1::Finding::SOLVE_FAILED);
  EXPECT_TRUE(fresh->next(fresh->runs(), runs));
}

TEST(RecipePlan, WithoutValidDraftsThereIsNoRecipe) {
  auto melting = request();
  melting.mutable_recipe()->mutable_numbers(4)->set_high(59.0);
  const auto plan = study_plan(melting);
  const auto runs = cast_all(*plan);
  EXPECT_EQ(runs.size(), 62U) << "nothing is proposed";
  const auto found = found_in(*plan, runs);
  EXPECT_EQ(found.chosen(), -1);
  EXPECT_THAT(found.fault(), HasSubstr("0 of 60 drafts"));
}

TEST(RecipePlan, FaultsNameWhatIsWrong) {
  EXPECT_EQ(fields_of(request()), "");

  auto faulty = request();
  v1::RecipePlan& plan = *faulty.mutable_recipe();
  plan.mutable_numbers(0)->set_name("speed");
  plan.mutable_numbers(1)->set_high(0.0);
  plan.set_greatest_curl_m(0.01);
  plan.set_drafts(3);
  plan.set_greatest_speed_rate_m_per_s2(0.0);
  EXPECT_EQ(
      fields_of(faulty),
      "recipe.numbers recipe.speed_run recipe.band recipe.greatest_speed_rate recipe.drafts ");

  auto unknown = request();
  unknown.mutable_recipe()->mutable_data(0)->set_key("schedule.casting_temperatur.offset");
  EXPECT_THAT(fields_of(unknown), HasSubstr("schedule"));
}

}  // namespace
}  // namespace dccast::studies
