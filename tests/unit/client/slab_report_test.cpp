#include <algorithm>
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/frame_bytes.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/pages.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/frames/contraction.hpp"
#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::client::render {
namespace {

using testing::DoubleNear;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

int count_of(const std::string& text, const std::string& part) {
  int count = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

/// Two by two by two hexahedra of 0.6 x 0.4 x 0.2 m, numbered by x, then y, then z. The lower half
/// is solid. The corner has risen by 20 mm; the wide face has drawn in by 2 % at the butt and by 1
/// % in the middle.
v1::Frame quarter() {
  v1::Frame frame;
  frame.set_dimension(3);
  frame.set_nodes_per_element(8);
  frame.set_time_s(250.0);
  frame.set_cast_length_m(0.2);
  frame.set_solidus_c(620);
  frame.set_liquidus_c(649);
  const double pull_in[3] = {8e-3, 4e-3, 0.0};
  for (int k = 0; k < 3; ++k)
    for (int j = 0; j < 3; ++j)
      for (int i = 0; i < 3; ++i) {
        for (const double x : {0.3 * i, 0.2 * j, 0.1 * k}) frame.add_node_m(x);
        for (const double u : {0.0, j == 2 ? -pull_in[k] : 0.0, i == 2 && j == 2 ? 20e-3 : 0.0})
          frame.add_displacement_m(u);
        frame.add_temperature_c(k == 0 ? 100.0 : k == 1 ? 400.0 : 680.0);
        if (k > 0) continue;
        frame.add_bottom_node(3 * j + i);
        frame.add_bottom_gap_m(i == 2 && j == 2 ? 20e-3 : 0.0);
        frame.add_bottom_pressure_pa(i == 0 && j < 2 ? 1e4 : 0.0);
      }
  for (int k = 0; k < 2; ++k)
    for (int j = 0; j < 2; ++j)
      for (int i = 0; i < 2; ++i) {
        const int n = 9 * k + 3 * j + i;
        for (const int node : {n, n + 1, n + 4, n + 3, n + 9, n + 10, n + 13, n + 12})
          frame.add_element_node(node);
      }
  return frame;
}

/// Faces whose outward normal points in a direction.
auto count_facing(const std::vector<SurfaceFace>& surface, const Vector3& direction) {
  return std::ranges::count_if(
      surface, [&](const SurfaceFace& face) { return dot(face.normal, direction) > 0.99; });
}

TEST(Surface, OfAQuarterHasEveryOuterFaceOnceAndNoInnerOne) {
  const auto surface = surface_of(quarter());
  ASSERT_EQ(surface.size(), 24u);  // four a side
  for (const Vector3& side : {Vector3{1, 0, 0}, Vector3{-1, 0, 0}, Vector3{0, 1, 0},
                              Vector3{0, -1, 0}, Vector3{0, 0, 1}, Vector3{0, 0, -1}})
    EXPECT_EQ(count_facing(surface, side), 4);
}

TEST(Surface, OfTwoTetrahedraLeavesTheFaceBetweenThemOut) {
  v1::Frame frame;
  frame.set_dimension(3);
  frame.set_nodes_per_element(4);
  for (const double x : {0., 0., 0., 1., 0., 0., 0., 1., 0., 0., 0., 1., 1., 1., 1.})
    frame.add_node_m(x);
  for (const int node : {0, 1, 2, 3, 1, 2, 3, 4}) frame.add_element_node(node);
  for (int i = 0; i < 5; ++i) frame.add_temperature_c(20.0 * i);
  const auto surface = surface_of(frame);
  ASSERT_EQ(surface.size(), 6u);
  for (const SurfaceFace& face : surface) EXPECT_NEAR(dot(face.normal, face.normal), 1.0, 1e-12);
  EXPECT_EQ(count_facing(surface, {0, 0, -1}), 1);
}

/// The metal level is level, and the liquid below it fills what the solid leaves.
TEST(DrawnDisplacement, LiquidStandsLevel) {
  v1::Frame frame = quarter();
  frame.set_metal_level_m(0.2);
  for (int n = 0; n < 9; ++n)
    frame.set_temperature_c(9 + n, 640.0);  // only the lowest row is solid
  for (int n = 18; n < 27; ++n) frame.set_displacement_m(3 * n + 2, 0.05);
  const auto drawn = drawn_displacement(frame);
  const auto up = [&](int n) { return drawn[std::size_t(3 * n + 2)]; };
  for (int n = 18; n < 27; ++n) EXPECT_EQ(up(n), 0.0) << n;

  EXPECT_EQ(up(8), 20e-3) << "the corner of the butt has risen";
  EXPECT_NEAR(up(17), 10e-3, 1e-15) << "half way from the front to the level";
  EXPECT_EQ(drawn[3 * 17 + 1], -4e-3) << "what moves sideways is what the mesh has";

  for (int n = 0; n < 9; ++n) frame.set_temperature_c(n, 640.0);
  const auto all_liquid = drawn_displacement(frame);
  for (std::size_t i = 2; i < all_liquid.size(); i += 3) EXPECT_EQ(all_liquid[i], 0.0);
}

/// The number of 32 bits at this place of the bytes of a frame.
template <class Number>
Number number_at(const std::string& bytes, std::size_t index) {
  Number number;
  std::memcpy(&number, bytes.data() + 4 * index, sizeof number);
  return number;
}

TEST(FrameBytes, HaveCountsThenPlacesDisplacementsAndTemperatures) {
  const v1::Frame frame = quarter();
  const std::string bytes = frame_bytes(frame, Precision::full).value();
  const int counts[] = {27, 8, 8, 48, 24, 3};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(number_at<std::int32_t>(bytes, i), counts[i]) << i;
  EXPECT_EQ(number_at<float>(bytes, 8), 250.0F);
  EXPECT_EQ(number_at<float>(bytes, 12 + 3 * 8), 0.6F) << "x of the corner of the butt";
  EXPECT_EQ(number_at<float>(bytes, 12 + 3 * 27 + 3 * 8 + 2), 20e-3F) << "it has risen";
  EXPECT_EQ(number_at<float>(bytes, 12 + 6 * 27 + 8), 100.0F);
  EXPECT_EQ(bytes.size(), 4u * (12 + 7 * 27 + 8 * 8 + 3 * 48 + 2 * 24));
}

TEST(FrameBytes, ASectionLiesInThePlaneOfWidthAndHeight) {
  v1::Frame frame;
  frame.set_dimension(2);
  frame.set_nodes_per_element(4);
  for (const double x : {0., 0., 1., 0., 1., 2., 0., 2.}) frame.add_node_m(x);
  for (const int node : {0, 1, 2, 3}) frame.add_element_node(node);
  for (int i = 0; i < 4; ++i) frame.add_temperature_c(20.0);
  const std::string bytes = frame_bytes(frame, Precision::full).value();
  const float expected[] = {1.0F, 0.0F, 2.0F};
  for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ(number_at<float>(bytes, 12 + 6 + c), expected[c]);
}

TEST(FrameBytes, OfADrawingAreRoundedToTwelveBits) {
  google::protobuf::RepeatedField<float> values;
  for (const float value : {660.1234F, -1e-3F, 0.0F, NAN}) values.Add(value);
  const std::string bytes = float_bytes(values, Precision::drawing);
  for (int i = 0; i < 3; ++i) {
    const auto rounded = number_at<float>(bytes, std::size_t(i));
    EXPECT_NEAR(rounded, values[i], std::abs(values[i]) / 4096.0);
    EXPECT_EQ(number_at<std::uint32_t>(bytes, std::size_t(i)) % 4096, 0u);
  }
  EXPECT_TRUE(std::isnan(number_at<float>(bytes, 3)));
}

TEST(FrameBytes, ThereAreNoneOfAFrameThatDoesNotFit) {
  v1::Frame frame = quarter();
  frame.set_element_node(0, 27);
  EXPECT_FALSE(frame_bytes(frame, Precision::full));
  frame = quarter();
  frame.mutable_element_node()->RemoveLast();
  EXPECT_FALSE(frame_bytes(frame, Precision::full));
  frame = quarter();
  frame.set_dimension(2);
  EXPECT_FALSE(frame_bytes(frame, Precision::full));
}

TEST(PlantUnits, NumbersAreAsTheUserWroteThem) {
  EXPECT_EQ(plant_number(60e3 * 0.0006666666666666668), "40");
  EXPECT_EQ(plant_number(0.1 + 0.2), "0.3");
  EXPECT_EQ(plant_number(12345.6), "12346");

  v1::Curve speed;
  speed.set_abscissa(v1::TIME);
  for (const double t : {60.0, 200.0}) speed.add_at(t);
  for (const double v : {0.0006666666666666668, 0.001}) speed.add_value(v);
  EXPECT_EQ(curve_in_words(speed, mm_per_min, "mm/min"),
            "40 mm/min to 60 s, then to 60 mm/min at 200 s");
  EXPECT_NEAR(mm_per_min * frames::curve_value(speed, 130.0, 0.0, 0.0), 50.0, 1e-9);
  EXPECT_NEAR(mm_per_min * frames::curve_value(speed, 1e3, 0.0, 0.0), 60.0, 1e-9);
  EXPECT_EQ(frames::curve_value(v1::Curve(), 1.0, 1.0, 7.0), 7.0);

  speed.set_abscissa(v1::CAST_LENGTH);
  speed.set_at(0, 0.1);
  speed.set_at(1, 0.2);
  EXPECT_NEAR(mm_per_min * frames::curve_value(speed, 0.0, 0.15, 0.0), 50.0, 1e-9);
}

TEST(PlantUnits, TheWholeCaseHasNoDigitsNobodyWrote) {
  v1::Case input;
  v1::Curve& speed = *input.mutable_schedule()->mutable_casting_speed_m_per_s();
  speed.set_abscissa(v1::TIME);
  speed.add_at(0.0);
  speed.add_value(0.0006666666666666668);
  v1::Curve& water = *input.mutable_schedule()->mutable_water_flow_m2_per_s();
  water.add_at(0.0);
  water.add_value(0.0015);
  input.mutable_validity()->set_maximum_rotation_rad(0.17453292519943295);
  input.set_title("case 0.12345678901234567 of m/s");
  const std::string text = readable_toml(input);

  EXPECT_THAT(text, HasSubstr("\"40 mm/min\""));
  EXPECT_THAT(text, HasSubstr("\"90 l/min/m\""));
  EXPECT_THAT(text, HasSubstr("\"0.174532925 rad\""));
  EXPECT_THAT(text, HasSubstr("case 0.12345678901234567 of m/s"));
}

/// A run of the frame with a corner that ends at 40 mm.
v1::QueryResultResponse run_with(double least_mm, double greatest_mm) {
  v1::QueryResultResponse result;
  *result.mutable_frame() = quarter();
  v1::Case& input = *result.mutable_case_();
  input.mutable_section()->set_kind(v1::Section::QUARTER_SLAB);
  input.mutable_plausibility()->set_least_curl_m(1e-3 * least_mm);
  input.mutable_plausibility()->set_greatest_curl_m(1e-3 * greatest_mm);
  input.mutable_schedule()->mutable_water_flow_m2_per_s()->add_value(3e-3);
  input.mutable_time()->set_end_s(250.0);
  for (int i = 1; i <= 5; ++i) {
    v1::StepReport& step = *result.add_steps();
    step.set_step(i);
    step.set_time_s(50.0 * i);
    step.set_shell_at_water_line_m(1e-3 * i);
    step.set_sump_depth_m(0.05 * i);
    step.mutable_section()->set_side_heat(1e5);
    step.mutable_section()->set_narrow_heat(5e4);
    step.set_contact_area_m2(0.01);
    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.set_curl_m(8e-3 * i);
    corner.set_temperature_c(300.0);
  }
  return result;
}

TEST(ReportPage, OfAQuarterSlabHasItsPicturesAndThePlantsFigures) {
  const std::string page = report_page(v1::Job(), run_with(35, 45));
  EXPECT_EQ(count_of(page, "data-kind='slab'"), 1);
  EXPECT_EQ(count_of(page, "<div class='gap-map'></div>"), 1);
  for (const char* const part :
       {"Gap under the butt", "180 l/min/m", "Shell", "Sump",
        "Temperatures", "Heat through each face", "Contact with the block", "narrow face",
        "Largest gap <strong>20.0 mm</strong> at x 600 mm, y 400 mm", "2 of 9 nodes",
        "<strong>100</strong> cm²"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* const absent : {"http://", "src=", ">nan", "nan mm", "Gap along the bottom"})
    EXPECT_THAT(page, Not(HasSubstr(absent)));
}

/// The drawn lines of a chart, by its title.
std::string chart_data(const std::string& page, const std::string& title) {
  const auto heading = page.find("\"heading\":\"" + title + "\"");
  const auto from = page.find("\"lines\":", heading);
  return page.substr(from, page.find("}]", from) - from);
}

/// A slab that cools down after 150 s is no longer cast, and no water runs.
TEST(ReportPage, SpeedAndWaterEndWithTheCasting) {
  v1::QueryResultResponse result = run_with(35, 45);
  EXPECT_THAT(chart_data(report_page(v1::Job(), result), "Casting speed"), HasSubstr("250"));

  result.mutable_case_()->mutable_time()->set_end_s(150.0);
  const std::string page = report_page(v1::Job(), result);
  for (const char* const title : {"Casting speed", "Water"}) {
    EXPECT_THAT(chart_data(page, title), HasSubstr("150")) << title;
    EXPECT_THAT(chart_data(page, title), Not(HasSubstr("200"))) << title;
  }
}

TEST(ReportPage, HasThePullInOfTheWideFaceAsFiguresAndAsLines) {
  v1::QueryResultResponse result;
  *result.mutable_case_() = frames::testing::quarter_slab();
  *result.mutable_frame() = frames::testing::cooled(frames::testing::hot_above);
  const std::string page = report_page(v1::Job(), result);
  for (const char* const part :
       {"<h2>Pull-in of the wide face</h2>", "\"quantity\":\"pull-in\"", "<th>pull-in, mm</th>",
        "<td>head</td>", "<td>butt</td>"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(report_page(v1::Job(), run_with(35, 45)), Not(HasSubstr("Pull-in")))
      << "of a frame whose case has no mould";
}

TEST(ReportPage, SaysHowTheCurlLiesInThePlantsBand) {
  const std::string inside = report_page(v1::Job(), run_with(35, 45));
  EXPECT_THAT(inside, HasSubstr("corner has risen <strong>40.0 mm</strong>"));
  EXPECT_THAT(inside, HasSubstr("It is inside the plant&#39;s band, 35 to 45 mm."));
  EXPECT_EQ(count_of(inside, "\"region\":{\"low\":0.035,\"high\":0.045"), 2);
  EXPECT_THAT(report_page(v1::Job(), run_with(10, 20)), HasSubstr("It is above the plant"));
  EXPECT_THAT(report_page(v1::Job(), run_with(50, 60)), HasSubstr("It is below the plant"));
}

TEST(ReportPage, TheFirstSheetIsTheOneToPinUp) {
  v1::QueryResultResponse result = run_with(35, 45);
  v1::Job job;
  job.add_findings()->set_message("too hot");
  for (v1::StepReport& step : *result.mutable_steps()) {
    step.set_time_step_s(50.0);
    step.mutable_section()->set_bottom_heat(5e4);
    step.set_wetted_share(0.2 * static_cast<double>(step.step()));
  }
  result.mutable_case_()->mutable_cooling()->mutable_water()->set_enabled(true);
  const std::string page = report_page(job, result);
  // A quarter of 40 mm is passed after 50 s, three quarters after 150 s.
  std::size_t at = 0;
  for (const char* const part :
       {"<div class='first'>", "has risen <strong>40.0 mm", "between 50 s and 150 s",
        "75 % of the heat left through the faces", "25 % through the bottom",
        "Water wetted 20 to 60 % of the side", "too hot", "Curl against time", "Recipe",
        "data-kind='slab'", "<div class='histories'>", "Curl against cast length", "Shell",
        "Gap under the butt", "<div class='evidence'>"}) {
    const auto found = page.find(part, at);
    ASSERT_NE(found, std::string::npos) << part << ", in this order";
    at = found;
  }
}

TEST(ReportPage, DangersAndFailuresStandAtTheTop) {
  v1::Job job;
  job.add_findings()->set_severity(v1::Finding::DANGER);
  job.mutable_failure()->set_kind(v1::Finding::WORKER_HUNG);
  job.mutable_failure()->set_message("no step <for> an hour");
  const std::string page = report_page(job, run_with(35, 45));
  const auto answer = page.find("has risen");
  EXPECT_LT(page.find("<span class='state failed'>1 danger</span>"), answer);
  EXPECT_LT(page.find("The run failed: worker hung: no step &lt;for&gt; an hour"), answer);
}

TEST(ReportPage, WhatHasNotCurledHasNoCause) {
  v1::QueryResultResponse result = run_with(35, 45);
  for (v1::StepReport& step : *result.mutable_steps()) step.mutable_monitors(0)->set_curl_m(0.0);
  EXPECT_THAT(report_page(v1::Job(), result), Not(HasSubstr("Half of it")));
}

/// The errors of every curl, relative to it.
void set_errors(double lower, double upper, v1::QueryResultResponse& result) {
  for (v1::StepReport& step : *result.mutable_steps())
    for (v1::MonitorValue& monitor : *step.mutable_monitors()) {
      monitor.set_curl_lower_error_m(lower * monitor.curl_m());
      monitor.set_curl_upper_error_m(upper * monitor.curl_m());
    }
}

TEST(ReportPage, AnErrorWithOneSideIsShownSo) {
  v1::QueryResultResponse result = run_with(35, 45);
  set_errors(0.0, 0.14, result);
  const std::string page = report_page(v1::Job(), result);
  EXPECT_THAT(page, HasSubstr("leave -0 +5.6 mm of it uncertain"));
  EXPECT_THAT(page, HasSubstr("-0 +5.60 mm"));
}

TEST(ReportPage, ACurlWithErrorsHasItsBand) {
  v1::QueryResultResponse result = run_with(35, 45);
  set_errors(0.04, 0.04, result);
  const std::string page = report_page(v1::Job(), result);
  EXPECT_THAT(page, HasSubstr("leave ± 1.6 mm of it uncertain"));
  EXPECT_THAT(page, HasSubstr("the band of the case's quality"));
  EXPECT_EQ(count_of(page, "\"low\":[0.00768,"), 2) << "in both charts of the curl";
  EXPECT_THAT(page, Not(HasSubstr("discretisation is not known")));
}

TEST(ReportPage, AFrameThatDoesNotFitIsSaidToBeAbsent) {
  v1::QueryResultResponse result = run_with(35, 45);
  result.mutable_frame()->clear_temperature_c();
  EXPECT_THAT(report_page(v1::Job(), result), HasSubstr("cannot be drawn"));
}

}  // namespace
}  // namespace dccast::client::render
