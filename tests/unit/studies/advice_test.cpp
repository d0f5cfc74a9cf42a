#include "server/studies/advice.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

namespace dccast::studies {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr double end_s = 200.0;

/// A study of castings whose plans curl by 20, 24, ... 48 mm at the corner, without levers so far.
class Study {
public:
  Study() {
    result_.mutable_study()->set_state(v1::STUDY_SUCCEEDED);
    result_.add_monitors("corner");
    result_.add_monitors("centre");
  }

  static constexpr int castings = 8;
  static double curl_mm(int casting) { return 20.0 + 4.0 * casting; }

  /// Adds a lever that is moved from a time on. @param corner_mm  by casting
  template <typename Effect>
  Study& add(const std::string& words, double from_s, const Effect& corner_mm,
             double shell_mm = 0.0) {
    for (int casting = 0; casting < castings; ++casting) {
      v1::LeverEffect effect;
      effect.mutable_step()->set_key(words);
      effect.mutable_step()->set_steps(-1);
      effect.mutable_step()->set_words(words);
      effect.mutable_step()->set_from_s(from_s);
      effect.add_curl_m(1e-3 * corner_mm(casting));
      effect.add_curl_m(0.0);
      effect.set_least_shell_m(1e-3 * shell_mm);
      effects_[static_cast<std::size_t>(casting)].push_back(effect);
    }
    return *this;
  }

  /// The same in all castings.
  Study& add(const std::string& words, double from_s, double corner_mm, double shell_mm = 0.0) {
    return add(
        words, from_s, [&](int) { return corner_mm; }, shell_mm);
  }

  /// The effect that was added last, in one casting.
  v1::LeverEffect& last(int casting) { return effects_[static_cast<std::size_t>(casting)].back(); }

  v1::StudyResult result(int count = castings) const {
    v1::StudyResult result = result_;
    for (int casting = 0; casting < count; ++casting) {
      v1::LeverEffect& plan = *result.add_lever_effects();
      plan.add_curl_m(1e-3 * curl_mm(casting));
      plan.add_curl_m(0.0);
      for (const v1::LeverEffect& effect : effects_[static_cast<std::size_t>(casting)])
        *result.add_lever_effects() = effect;
    }
    return result;
  }

private:
  v1::StudyResult result_;
  std::vector<v1::LeverEffect> effects_[castings];
};

/// A casting whose corner ends at 36 mm, give or take.
struct Casting {
  double curl_mm = 36.0;
  double band_mm = 0.0;
};

v1::Forecast advice_at(double time_s, const v1::StudyResult& study,
                       const std::vector<std::string>& monitors = {"corner"},
                       Casting casting = {}) {
  v1::Following following;
  v1::Forecast forecast;
  forecast.set_time_s(time_s);
  for (const std::string& monitor : monitors) {
    following.add_gauges()->set_monitor(monitor);
    v1::ForecastCurl& curl = *forecast.add_curls();
    curl.add_time_s(end_s);
    curl.add_curl_m(1e-3 * casting.curl_mm);
    curl.add_lower_m(1e-3 * (casting.curl_mm - casting.band_mm));
    curl.add_upper_m(1e-3 * (casting.curl_mm + casting.band_mm));
  }
  add_advice(study, following, forecast);
  return forecast;
}

double corner_mm(const v1::Forecast& forecast) {
  return 1e3 * forecast.levers(0).curls(0).curl_m();
}

double half_band_mm(const v1::Forecast& forecast) {
  const v1::ExpectedCurl& curl = forecast.levers(0).curls(0);
  return 1e3 * 0.5 * (curl.upper_m() - curl.lower_m());
}

/// An effect that falls linearly to nothing at the end is met exactly, whenever it was computed.
TEST(Advice, IsLinearBetweenTheTimesThatWereComputedAndNothingAtTheEnd) {
  Study study;
  for (const double from_s : {120.0, 0.0, 20.0})
    study.add("less water", from_s, -4.0 * (1.0 - from_s / end_s), -1.0 * (1.0 - from_s / end_s));
  for (const double now_s : {0.0, 10.0, 20.0, 75.0, 120.0, 160.0, 200.0}) {
    const v1::Forecast forecast = advice_at(now_s, study.result());
    EXPECT_NEAR(corner_mm(forecast), -4.0 * (1.0 - now_s / end_s), 1e-9) << now_s;
    EXPECT_NEAR(forecast.levers(0).least_shell_m(), -1e-3 * (1.0 - now_s / end_s), 1e-12);
  }
  EXPECT_NEAR(corner_mm(advice_at(-30.0, study.result())), -4.0, 1e-9) << "before the casting";
  EXPECT_NEAR(corner_mm(advice_at(300.0, study.result())), 0.0, 1e-9);
}

/// An effect that is a straight line in the curl of the casting is met exactly.
TEST(Advice, IsThatOfACastingWithThisCurl) {
  Study study;
  study.add("less water", 0.0, [](int casting) { return -8.0 + 0.2 * Study::curl_mm(casting); });
  EXPECT_NEAR(corner_mm(advice_at(0.0, study.result(), {"corner"}, {.curl_mm = 22.0})), -3.6, 1e-9);
  EXPECT_NEAR(corner_mm(advice_at(0.0, study.result(), {"corner"}, {.curl_mm = 50.0})), 2.0, 1e-9);

  // What is not known of the curl is not known of the effect.
  const double known = half_band_mm(advice_at(0.0, study.result()));
  const double vague = half_band_mm(advice_at(0.0, study.result(), {"corner"}, {.band_mm = 10.0}));
  EXPECT_NEAR(vague, std::hypot(known, 0.2 * 10.0), 1e-9);
}

/// The band of a scatter about the line holds nine of ten new castings: Student's t of 6 degrees of
/// freedom is 1.943.
TEST(Advice, HasTheBandOfTheScatterBetweenCastings) {
  Study study;
  // A quadratic in the number of the casting has no part along the line.
  const auto scatter = [](int casting) {
    return casting % 4 == 0 || casting % 4 == 3 ? 3.0 : -3.0;
  };
  study.add("less water", 0.0, scatter);
  const v1::Forecast forecast = advice_at(0.0, study.result(), {"corner"}, {.curl_mm = 34.0});
  EXPECT_NEAR(corner_mm(forecast), 0.0, 1e-9);
  const double of_line = 1.943 * std::sqrt(8 * 9.0 / 6.0 * (1.0 + 1.0 / 8.0));
  EXPECT_NEAR(half_band_mm(forecast), std::hypot(of_line, 1.645 * 0.3), 0.05 * of_line);
}

TEST(Advice, IsGivenAsASentenceWithItsBand) {
  const v1::Forecast forecast =
      advice_at(0.0, Study().add("use 20 % less water", 0.0, -2.0, -0.4).result());
  ASSERT_EQ(forecast.advice_size(), 1);
  EXPECT_THAT(
      forecast.advice(0),
      AllOf(HasSubstr("use 20 % less water than planned from now on: corner -2.0 mm at the end "
                      "("),
            HasSubstr("least shell -0.4 mm")));
  const v1::ExpectedCurl& curl = forecast.levers(0).curls(0);
  EXPECT_LT(curl.lower_m(), curl.curl_m());
  EXPECT_LT(curl.upper_m(), 0.0);
  EXPECT_TRUE(forecast.levers(0).is_advised());
}

TEST(Advice, NeedsMoreThanAMillimetre) {
  Study study;
  study.add("less water", 0.0, -2.0).add("colder", 0.0, -0.9).add("hotter", 0.0, 2.0);
  EXPECT_THAT(advice_at(80.0, study.result()).advice(), ElementsAre(HasSubstr("less water")))
      << "1.2 mm are left";
  EXPECT_THAT(advice_at(110.0, study.result()).advice(),
              ElementsAre("no lever lowers the corner by more than 1 mm any more"));
}

TEST(Advice, IsNoneWhereTheGainMayBeALoss) {
  Study study;
  study.add("less water", 0.0, [](int casting) { return casting % 2 == 0 ? -6.0 : 2.0; });
  const v1::Forecast forecast = advice_at(0.0, study.result());
  EXPECT_LT(corner_mm(forecast), -1.0);
  EXPECT_FALSE(forecast.levers(0).is_advised());
}

TEST(Advice, IsOrderedByItsGain) {
  Study study;
  study.add("colder", 0.0, -1.5).add("less water", 0.0, -2.5);
  EXPECT_THAT(advice_at(0.0, study.result()).advice(),
              ElementsAre(HasSubstr("less water"), HasSubstr("colder")));
}

TEST(Advice, IsNoneWhereAFindingBecomesWorseInARunAroundNow) {
  Study study;
  study.add("less water", 0.0, -4.0).add("less water", 20.0, -4.0);
  study.last(3).add_worse("water_thrown_off");
  study.add("less water", 60.0, -4.0).add("less water", 120.0, -4.0);
  for (const double now_s : {0.0, 10.0, 30.0})
    EXPECT_THAT(advice_at(now_s, study.result()).advice(),
                ElementsAre("no lever lowers the corner by more than 1 mm without making a finding "
                            "worse: \"less water\" does so for water_thrown_off"));
  EXPECT_TRUE(advice_at(70.0, study.result()).levers(0).is_advised());
}

TEST(Advice, IsNoneWhereAnotherGaugeRises) {
  Study study;
  study.add("less water", 0.0, -2.0);
  for (int casting = 0; casting < Study::castings; ++casting)
    study.last(casting).set_curl_m(1, 2e-3);
  EXPECT_TRUE(advice_at(0.0, study.result()).levers(0).is_advised()) << "nobody measures it";
  EXPECT_THAT(advice_at(0.0, study.result(), {"corner", "centre"}).advice(),
              ElementsAre("no lever lowers the corner or the centre by more than 1 mm any more"));
}

/// A run that failed has no effect, and stands in the way of the advice around it.
TEST(Advice, OfARunThatFailedIsNotKnown) {
  Study study;
  study.add("less water", 0.0, -3.0);
  study.last(0).set_curl_m(0, NAN);
  study.last(0).clear_least_shell_m();
  study.last(0).add_worse("shell_melted_through");
  study.add("less water", 60.0, -3.0);
  const v1::Forecast forecast = advice_at(0.0, study.result());
  EXPECT_NEAR(corner_mm(forecast), -3.0, 1e-9) << "of the other castings";
  EXPECT_FALSE(forecast.levers(0).is_advised());
  EXPECT_TRUE(advice_at(70.0, study.result()).levers(0).is_advised());
}

TEST(Advice, WaitsForTheEndOfTheStudyAndNeedsFiveCastings) {
  Study study;
  study.add("less water", 0.0, -2.0);
  v1::StudyResult result = study.result();
  result.mutable_study()->set_state(v1::STUDY_RUNNING);
  EXPECT_THAT(advice_at(0.0, result).advice(), IsEmpty());
  EXPECT_THAT(advice_at(0.0, study.result(4)).advice(), IsEmpty());
  EXPECT_THAT(advice_at(0.0, study.result(5)).advice(), SizeIs(1));
}

}  // namespace
}  // namespace dccast::studies
