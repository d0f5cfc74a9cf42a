#include "server/studies/measured_castings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/statistics/sampling.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {
namespace {

using testing::HasSubstr;

constexpr double low_1 = 660.0, high_1 = 700.0, low_2 = 50.0, high_2 = 110.0;
constexpr int seconds = 100;

/// Curl [m] of places from 0 to 1: a height by the first key, a rate by the second one.
double curl(double a, double b, double t) {
  return 1e-3 * (20.0 + 20.0 * a) * (1.0 - std::exp(-(0.01 + 0.05 * b) * t));
}

/// Temperature [degC] at the same monitor: the second key alone.
double temperature(double b, double t) {
  return 600.0 - (2.0 + 2.0 * b) * t;
}

v1::CreateStudyRequest hypercube() {
  v1::CreateStudyRequest request;
  request.mutable_case_()->add_monitor()->set_name("corner");
  auto& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::LATIN_HYPERCUBE);
  sweep.set_runs(20);
  const auto axis = [&](const char* key, const char* low, const char* high) {
    auto& added = *sweep.add_axes();
    added.set_key(key);
    added.add_values(low);
    added.add_values(high);
  };
  axis("schedule.casting_temperature", "660 degC", "700 degC");
  axis("cooling.bottom_block.temperature", "50 degC", "110 degC");
  return request;
}

/// Error that a surface of 20 runs cannot avoid [m].
double rough(double a, double b, double t) {
  return 0.5e-3 * (1.0 - std::exp(-0.05 * t)) *
         (std::sin(11.0 * a + 7.0 * b) + std::cos(17.0 * a - 13.0 * b + 0.05 * t));
}

EvaluatedRun run_at(double a, double b, double bend = 0.0, double roughness = 0.0) {
  EvaluatedRun run;
  run.run.set_state(v1::SUCCEEDED);
  run.run.add_numbers(low_1 + a * (high_1 - low_1));
  run.run.add_numbers(low_2 + b * (high_2 - low_2));
  v1::CurlCurve& curve = run.history.curves.emplace_back();
  curve.set_monitor("corner");
  for (int t = 1; t <= seconds; ++t) {
    curve.add_time_s(t);
    curve.add_cast_length_m(1e-3 * t);
    curve.add_curl_m(curl(a, b, t) + bend * t / seconds + roughness * rough(a, b, t));
    run.history.temperature_c["corner"].push_back(temperature(b, t));
  }
  return run;
}

/// Readings of a casting with hidden values, every `stride` seconds.
v1::MeasuredCurve measured(double a, double b, int stride = 5, bool by_length = false,
                           double noise_m = 0.3e-3) {
  v1::MeasuredCurve curve;
  curve.set_monitor("corner");
  curve.set_source("a.csv");
  std::mt19937_64 random(5);
  for (int t = stride; t <= seconds; t += stride) {
    by_length ? curve.add_cast_length_m(1e-3 * t) : curve.add_time_s(t);
    curve.add_curl_m(curl(a, b, t) + noise_m * statistics::normal(random));
  }
  return curve;
}

MeasuredCasting casting_of(const v1::MeasuredCurve& curve, int runs = 20) {
  MeasuredCasting casting;
  casting.request = hypercube();
  *casting.request.mutable_sweep()->add_measured() = curve;
  const Eigen::MatrixXd places = statistics::hypercube(runs, 2, 1);
  for (const auto& place : places.rowwise()) casting.runs.push_back(run_at(place[0], place[1]));
  return casting;
}

TEST(CalibrationOf, FindsHiddenValuesAndSaysThemAsInACaseFile) {
  const auto calibration = calibration_of({casting_of(measured(0.3, 0.6))});
  ASSERT_EQ(calibration.keys_size(), 2);
  EXPECT_LT(calibration.keys(0).low(), 0.3);
  EXPECT_GT(calibration.keys(0).high(), 0.3);
  EXPECT_LT(calibration.keys(1).low(), 0.6);
  EXPECT_GT(calibration.keys(1).high(), 0.6);
  EXPECT_LT(calibration.keys(0).narrowed(), 0.5);
  EXPECT_THAT(calibration.keys(0).best_text(), testing::EndsWith(" degC"));
  EXPECT_NEAR(std::stod(calibration.keys(0).best_text()), 660.0 + 40.0 * calibration.keys(0).best(),
              1e-3);
  EXPECT_EQ(calibration.fixed(), 2);
  EXPECT_FALSE(calibration.has_mesh_error());  // not known for such a case
  ASSERT_EQ(calibration.curves_size(), 1);

  const auto& curve = calibration.curves(0);
  EXPECT_EQ(curve.readings(), 20);
  EXPECT_LT(curve.off_after(), 0.6e-3);
  EXPECT_GT(curve.off_before(), 2.0 * curve.off_after());
  for (int i = 0; i < curve.time_s_size(); ++i) {
    EXPECT_LE(curve.before().low(i), curve.after().median(i));
    EXPECT_GE(curve.after().high(i) + 1e-6, curve.best(i));
  }
  ASSERT_EQ(calibration.checks_size(), 5);
  EXPECT_EQ(calibration.checks(0).values(1), calibration.keys(1).best_text());
  EXPECT_FALSE(curve.has_check_error());
}

TEST(CalibrationOf, IsTheSameEachTime) {
  const auto text = [] {
    return calibration_of({casting_of(measured(0.3, 0.6))}).SerializeAsString();
  };
  EXPECT_EQ(text(), text());
}

/// A slab that rocks: the surface is off by more than the readings, in the same way for many of
/// them.
TEST(CalibrationOf, HoldsHiddenValuesOnARoughSurfaceToo) {
  constexpr int castings = 10;
  std::mt19937_64 random(11);
  MeasuredCasting casting = casting_of(measured(0.5, 0.5));
  casting.runs.clear();
  const Eigen::MatrixXd places = statistics::hypercube(20, 2, 1);
  for (const auto& place : places.rowwise())
    casting.runs.push_back(run_at(place[0], place[1], 0.0, 1.0));
  int held = 0;
  for (int k = 0; k < castings; ++k) {
    const double hidden[] = {0.1 + 0.8 * statistics::uniform(random),
                             0.1 + 0.8 * statistics::uniform(random)};
    v1::MeasuredCurve curve = measured(hidden[0], hidden[1], 5, false, 0.01e-3);
    for (int i = 0; i < curve.curl_m_size(); ++i)
      curve.set_curl_m(i, curve.curl_m(i) + rough(hidden[0], hidden[1], curve.time_s(i)));
    *casting.request.mutable_sweep()->mutable_measured(0) = curve;
    const auto calibration = calibration_of({casting});
    for (int j = 0; j < 2; ++j)
      held += calibration.keys(j).low() <= hidden[j] && hidden[j] <= calibration.keys(j).high();
  }
  EXPECT_GE(held, 2 * castings * 8 / 10);
}

TEST(CalibrationOf, TakesReadingsByLengthAndAveragesMany) {
  const auto by_length = calibration_of({casting_of(measured(0.3, 0.6, 1, true))});
  const auto& used = by_length.curves(0).measured();
  EXPECT_EQ(by_length.curves(0).readings(), 100);
  EXPECT_EQ(used.time_s_size(), 40);
  EXPECT_NEAR(used.time_s(39), 99.0, 1.0);
  EXPECT_LT(by_length.keys(0).low(), 0.3);
  EXPECT_GT(by_length.keys(0).high(), 0.3);
}

TEST(CalibrationOf, LeavesOutReadingsBeyondTheComputedTime) {
  v1::MeasuredCurve longer = measured(0.3, 0.6);
  longer.add_time_s(5000.0);
  longer.add_curl_m(1.0);
  const auto calibration = calibration_of({casting_of(longer)});
  EXPECT_EQ(calibration.curves(0).readings(), 21);
  EXPECT_EQ(calibration.curves(0).measured().time_s_size(), 20);
}

TEST(CalibrationOf, ChecksTheSurfaceByTheLastRuns) {
  MeasuredCasting right = casting_of(measured(0.3, 0.6)), wrong = right;
  for (const double a : {0.25, 0.3, 0.35}) {
    right.runs.push_back(run_at(a, 0.6));
    wrong.runs.push_back(run_at(a, 0.6, 5e-3));  // not what the surface learned
  }
  right.last = wrong.last = 3;
  const auto good = calibration_of({right}).curves(0), bad = calibration_of({wrong}).curves(0);
  EXPECT_LT(good.check_error(), 2.0 * good.checked_error() + 1e-5);
  EXPECT_GT(bad.check_error(), 2.5e-3);
  EXPECT_TRUE(good.is_confirmed());
  EXPECT_FALSE(bad.is_confirmed());
  EXPECT_GT(bad.surface_error(), good.surface_error());  // they are part of it now
}

/// A temperature knows the second key, which the curl alone may trade against the first.
TEST(CalibrationOf, TakesTemperaturesAndSeveralCastings) {
  v1::MeasuredCurve thermocouple;
  thermocouple.set_monitor("corner");
  thermocouple.set_source("b.csv");
  thermocouple.set_noise(2.0);
  for (int t = 5; t <= seconds; t += 5) {
    thermocouple.add_time_s(t);
    thermocouple.add_temperature_c(temperature(0.6, t) + (t % 10 == 0 ? 1.5 : -1.5));
  }
  const auto calibration =
      calibration_of({casting_of(measured(0.3, 0.6)), casting_of(thermocouple)});

  ASSERT_EQ(calibration.curves_size(), 2);
  EXPECT_EQ(calibration.curves(1).casting(), 1);
  EXPECT_EQ(calibration.curves(1).noise().median(), 2.0);
  EXPECT_LT(calibration.keys(1).low(), 0.6);
  EXPECT_GT(calibration.keys(1).high(), 0.6);
  EXPECT_LT(calibration.keys(1).narrowed(),
            calibration_of({casting_of(measured(0.3, 0.6))}).keys(1).narrowed());
}

TEST(CalibrationOf, SaysWhatIsMissing) {
  const auto reason = [](std::vector<MeasuredCasting> castings) -> std::string {
    try {
      calibration_of(std::move(castings));
    } catch (const CannotPredict& fault) {
      return fault.what();
    }
    return {};
  };
  EXPECT_THAT(reason({casting_of(measured(0.3, 0.6), 4)}), HasSubstr("needs 5 valid runs"));

  MeasuredCasting other = casting_of(measured(0.3, 0.6));
  other.request.mutable_sweep()->mutable_axes(0)->set_values(0, "650 degC");
  EXPECT_THAT(reason({casting_of(measured(0.3, 0.6)), other}), HasSubstr("different free keys"));

  MeasuredCasting late = casting_of(measured(0.3, 0.6));
  for (double& time_s : *late.request.mutable_sweep()->mutable_measured(0)->mutable_time_s())
    time_s += 1000.0;
  EXPECT_THAT(reason({late}), HasSubstr("no reading within the computed time"));

  MeasuredCasting lost = casting_of(measured(0.3, 0.6));
  for (EvaluatedRun& run : lost.runs) run.history.temperature_c.clear();
  auto& curve = *lost.request.mutable_sweep()->mutable_measured(0);
  *curve.mutable_temperature_c() = curve.curl_m();
  curve.clear_curl_m();
  EXPECT_THAT(reason({lost}), HasSubstr("temperature of corner (a.csv) is in no run"));
}

TEST(SweepFaults, OfMeasuredCurvesNameTheCurve) {
  const auto fault_of = [](const auto& change) {
    v1::CreateStudyRequest request = hypercube();
    *request.mutable_sweep()->add_measured() = measured(0.3, 0.6);
    change(*request.mutable_sweep()->mutable_measured(0));
    const auto faults = plan_faults(request);
    return faults.empty() ? std::string() : faults.front().field() + " " + faults.front().message();
  };
  EXPECT_EQ(fault_of([](v1::MeasuredCurve&) {}), "");
  EXPECT_THAT(fault_of([](auto& curve) { curve.set_monitor("edge"); }),
              HasSubstr("sweep.measured[0].monitor the case has no such monitor"));
  EXPECT_THAT(fault_of([](auto& curve) { curve.add_time_s(1e4); }), HasSubstr("not complete"));
  EXPECT_THAT(fault_of([](auto& curve) { curve.add_temperature_c(1.0); }),
              HasSubstr("not complete"));
  EXPECT_THAT(fault_of([](auto& curve) { curve.set_source("a\x1b[2J.csv"); }),
              HasSubstr("sweep.measured[0].source is no name of a file"));
  EXPECT_THAT(fault_of([](auto& curve) { curve.set_time_s(1, 0.0); }), HasSubstr("not in order"));
  EXPECT_THAT(fault_of([](auto& curve) { curve.set_curl_m(1, std::nan("")); }),
              HasSubstr("no numbers"));
}

}  // namespace
}  // namespace dccast::studies
