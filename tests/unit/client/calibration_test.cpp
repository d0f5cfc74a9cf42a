#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "client/html/pages.hpp"
#include "client/model/measured_csv.hpp"
#include "client/model/study.hpp"
#include "client/text/data_study_text.hpp"

namespace dccast::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

MeasuredFile read(const std::string& text) {
  std::istringstream stream(text);
  return read_measured(stream, "curl.csv", {"corner", "tc 1"});
}

std::string fault(const std::string& text) {
  const auto faults = read(text).faults;
  return faults.empty() ? "" : faults.front();
}

TEST(MeasuredCsv, ReadsColumnsWithUnits) {
  const MeasuredFile file = read(
      "# a casting\n\ntime [min], curl corner [mm], temperature tc 1 (K)\n"
      "0, 0.0, 900\n0.5, 1.5,\n1, 2.5, 873.15\n");
  ASSERT_TRUE(file.faults.empty()) << file.faults.front();
  ASSERT_EQ(file.curves.size(), 2u);
  EXPECT_THAT(file.curves[0].time_s(), ElementsAre(0.0, 30.0, 60.0));
  EXPECT_THAT(file.curves[0].curl_m(), ElementsAre(0.0, 1.5e-3, 2.5e-3));
  EXPECT_EQ(file.curves[0].monitor(), "corner");
  EXPECT_EQ(file.curves[0].source(), "curl.csv");
  EXPECT_THAT(file.curves[1].time_s(), ElementsAre(0.0, 60.0));  // an empty cell is no reading
  EXPECT_NEAR(file.curves[1].temperature_c(1), 600.0, 1e-9);
}

TEST(MeasuredCsv, ReadsLengthsInchesAndSemicolons) {
  const MeasuredFile file = read("cast length [mm];gap corner [in]\r\n10;0.1\r\n20;0.2\r\n");
  ASSERT_TRUE(file.faults.empty()) << file.faults.front();
  EXPECT_THAT(file.curves[0].cast_length_m(), ElementsAre(0.01, 0.02));
  EXPECT_NEAR(file.curves[0].curl_m(1), 5.08e-3, 1e-12);
}

TEST(MeasuredCsv, FaultsNameLineColumnAndWhatIsPermitted) {
  EXPECT_EQ(fault("time [s],corner [mm]\n0,0\n1,x\n"),
            "curl.csv:3:2: \"x\" is no number; permitted: digits with a point, e.g. 12.5");
  EXPECT_THAT(fault("time,corner [mm]\n"),
              HasSubstr("curl.csv:1:1: \"time\" has no unit; permitted"));
  EXPECT_THAT(fault("time [K],corner [mm]\n"), HasSubstr("is no time and no length"));
  EXPECT_THAT(fault("time [s],corner [MPa]\n"), HasSubstr("curl.csv:1:2: [MPa]"));
  EXPECT_THAT(fault("time [s],edge [mm]\n"),
              HasSubstr("\"edge\" is no monitor of the case; permitted: corner, tc 1"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,0\n1,1\n"), HasSubstr("curl.csv:3:1: 1 does not lie"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1\n"), HasSubstr("has 1 columns; permitted: 2"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,nan\n"), HasSubstr("is no number"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,2\n"), HasSubstr("has 1 readings; permitted: 2"));
  EXPECT_THAT(fault("\n# nothing\n"), HasSubstr("is empty"));
}

/// A calibration of three keys, the second of which has moved with the first.
v1::StudyResult calibrated() {
  v1::StudyResult result;
  result.mutable_study()->set_id("0f8fad5b-d9cb-469f-a165-70867728950e");
  for (const auto& [key, low, high] : {std::tuple("alloy.specific_heat.scale", "0.95", "1.05"),
                                       std::tuple("cooling.bottom_block.wet_gap", "2 mm", "5 mm"),
                                       std::tuple("cooling.water.wetting.lag", "0.5 s", "5 s")}) {
    auto& axis = *result.mutable_study()->mutable_sweep()->add_axes();
    axis.set_key(key);
    axis.add_values(low);
    axis.add_values(high);
  }

  auto& calibration = *result.mutable_calibration();
  const auto add = [&](double narrowed, const char* low, const char* best, const char* high) {
    auto& key = *calibration.add_keys();
    key.set_narrowed(narrowed);
    key.set_low_text(low);
    key.set_best_text(best);
    key.set_high_text(high);
    for (int i = 0; i < 3; ++i) key.add_correlation(0.0);
  };

  add(0.2, "0.971234", "0.98", "0.991");
  add(0.4, "2.4 mm", "2.71828 mm", "3 mm");
  add(0.95, "0.7 s", "2.5 s", "4.8 s");
  calibration.mutable_keys(1)->set_correlation(0, -0.87);

  calibration.set_fixed(1);
  calibration.set_mesh_error(0.2);
  calibration.add_runs(64);

  auto& curve = *calibration.add_curves();
  curve.mutable_measured()->set_monitor("corner");
  curve.mutable_measured()->set_source("curl.csv");
  curve.set_readings(80);
  for (int i = 0; i < 3; ++i) {
    curve.mutable_measured()->add_time_s(i);
    curve.mutable_measured()->add_curl_m(1e-3 * i);
    curve.add_time_s(i);
    curve.add_best(1e-3 * i);
    for (auto* band : {curve.mutable_before(), curve.mutable_after()}) {
      band->add_low(0.8e-3 * i);
      band->add_median(1e-3 * i);
      band->add_high(1.2e-3 * i);
    }
  }
  curve.set_surface_error(0.2e-3);
  curve.set_check_error(0.3e-3);
  curve.set_checked_error(0.2e-3);

  for (auto* share : {curve.mutable_noise(), curve.mutable_misfit()}) {
    share->set_low(0.1e-3);
    share->set_median(0.5e-3);
    share->set_high(0.9e-3);
  }

  return result;
}

TEST(CalibrationText, ShowsWhatIsNarrowedAndWhatCannotBeSeparated) {
  const std::string text = render::calibration_text(calibrated());
  EXPECT_THAT(text, HasSubstr("± 5 %"));
  EXPECT_THAT(text, HasSubstr("0.9712..0.991 times"));
  EXPECT_THAT(text, HasSubstr("2.718 mm  2.4..3 mm"));
  EXPECT_THAT(text, HasSubstr("narrows alloy.specific_heat and cooling.bottom_block.wet_gap."));
  EXPECT_THAT(text, HasSubstr("does not narrow cooling.water.wetting.lag"));
  EXPECT_THAT(text,
              HasSubstr("cannot separate alloy.specific_heat and cooling.bottom_block.wet_gap:"));
  EXPECT_THAT(text, HasSubstr("it fixes 1 combination."));
  EXPECT_THAT(text, HasSubstr("needs no misfit"));
  EXPECT_THAT(text, HasSubstr("± 20 % of a curl"));
  EXPECT_THAT(text, HasSubstr("it holds"));

  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 120u) << line;
}

TEST(CalibrationText, SaysThatTheModelIsWrongAndThatTheSurfaceDidNotHold) {
  v1::StudyResult result = calibrated();
  auto& curve = *result.mutable_calibration()->mutable_curves(0);
  curve.mutable_misfit()->set_low(0.6e-3);
  curve.set_check_error(2e-3);
  const std::string text = render::calibration_text(result);
  EXPECT_THAT(text, HasSubstr("something is wrong or"));
  EXPECT_THAT(text, HasSubstr("it did not hold"));
}

TEST(CalibrationText, SaysWhenTheFitBecameWorse) {
  v1::StudyResult result = calibrated();
  auto& curve = *result.mutable_calibration()->mutable_curves(0);
  curve.set_off_before(0.2e-3);
  curve.set_off_after(0.5e-3);
  EXPECT_THAT(
      render::calibration_text(result),
      HasSubstr("The fit to the curl of corner became worse: 0.20 off before, 0.50 mm after."));
  curve.set_off_after(0.1e-3);
  EXPECT_THAT(render::calibration_text(result), testing::Not(HasSubstr("became worse")));
}

TEST(CalibrationText, OfTooFewRunsSaysWhy) {
  v1::StudyResult result = calibrated();
  result.clear_calibration();
  result.set_calibration_fault("needs 43 valid runs");
  EXPECT_THAT(render::calibration_text(result), HasSubstr("No answer yet: needs 43 valid runs"));
  EXPECT_THAT(render::calibration_page(result), HasSubstr("needs 43 valid runs"));
}

TEST(CalibrationPage, DrawsMeasuredOverComputedWithAllBands) {
  const std::string page = render::calibration_page(calibrated());
  for (const char* part : {"measured", "data before, 5 to 95 %", "data after, 5 to 95 %",
                           "mesh and time steps", "curl of corner, mm"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(page, HasSubstr("<circle cx=")) << "readings are dots";
}

TEST(Rounded, KeepsFourDigitsAndTheUnit) {
  EXPECT_EQ(rounded("0.9312345"), "0.9312");
  EXPECT_EQ(rounded("231.456 degC"), "231.5 degC");
  EXPECT_EQ(rounded("1234567 W/m2"), "1235000 W/m2");
  EXPECT_EQ(rounded("-0.000123456 K"), "-0.0001235 K");
  EXPECT_EQ(rounded("0 K"), "0 K");
}

}  // namespace
}  // namespace dccast::client
