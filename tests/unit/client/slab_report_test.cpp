#include <cmath>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/colour_bands.hpp"
#include "client/html/frame_picture.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/pages.hpp"
#include "client/html/slab_charts.hpp"
#include "client/html/svg_chart.hpp"
#include "client/text/plant_units.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/frames/contraction.hpp"

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

TEST(Surface, OfAQuarterHasEveryOuterFaceOnceAndNoInnerOne) {
  const auto surface = surface_of(quarter());
  ASSERT_EQ(surface.size(), 24u);  // four a side
  for (const Vector3& side : {Vector3{1, 0, 0}, Vector3{-1, 0, 0}, Vector3{0, 1, 0},
                              Vector3{0, -1, 0}, Vector3{0, 0, 1}, Vector3{0, 0, -1}})
    EXPECT_EQ(facing(surface, side, 0.99).size(), 4u);
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
  EXPECT_EQ(facing(surface, {0, 0, -1}, 0.99).size(), 1u);
  EXPECT_EQ(pictures_of(frame, {}).pictures.size(), 3u);
}

double area_of(const std::vector<Point>& p) {
  double twice = 0.0;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const Point &a = p[i], &b = p[(i + 1) % p.size()];
    twice += a.x * b.y - b.x * a.y;
  }
  return std::abs(twice) / 2.0;
}

TEST(ColourBands, CutATriangleIntoPiecesThatCoverItOnce) {
  const ColourBands bands{0.0, 10.0, 5};
  double area = 0.0;
  std::vector<int> found;
  // The field is 10 x: the part below level v has the share 1 - (1 - v / 10)^2 of the triangle.
  for (const BandPiece& piece : band_pieces({{{0, 0}, {1, 0}, {0, 1}}}, {0, 10, 0}, bands)) {
    area += area_of(piece.outline);
    found.push_back(piece.band);
    const double low = 0.2 * piece.band, high = low + 0.2;
    EXPECT_NEAR(area_of(piece.outline), 0.5 * ((1 - low) * (1 - low) - (1 - high) * (1 - high)),
                1e-12);
  }

  EXPECT_THAT(found, ElementsAre(0, 1, 2, 3, 4));
  EXPECT_NEAR(area, 0.5, 1e-12);
}

TEST(ColourBands, AValueOutsideTheRangeHasTheColourOfItsEnd) {
  const auto pieces = band_pieces({{{0, 0}, {1, 0}, {0, 1}}}, {-5, -5, -5}, {0.0, 10.0, 5});
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].band, 0);
  EXPECT_NEAR(area_of(pieces[0].outline), 0.5, 1e-12);
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

TEST(SlabPicture, HasThreeViewsWithTheSidesThatAreSeen) {
  const FramePictures found = pictures_of(quarter(), {100, 680});
  ASSERT_EQ(found.pictures.size(), 3u);
  EXPECT_DOUBLE_EQ(found.displacement_scale, 1.0);  // 0.6 m / 15 / 20 mm is less than a factor
  EXPECT_EQ(found.pictures[1].name, "from outside, below");
  const std::string& svg = found.pictures[1].svg;
  EXPECT_THAT(svg, HasSubstr(">butt</text>"));
  EXPECT_THAT(svg, Not(HasSubstr(">metal level</text>")));
  EXPECT_THAT(found.pictures[2].svg, HasSubstr(">middle, x = 0</text>"));
}

TEST(SlabPicture, SmallDisplacementsAreDrawnLargerByARoundFactor) {
  v1::Frame frame = quarter();
  for (double& u : *frame.mutable_displacement_m()) u *= 0.1;
  EXPECT_DOUBLE_EQ(pictures_of(frame, {}).displacement_scale, 10.0);
}

TEST(SlabPicture, AFrameThatDoesNotFitIsNotDrawn) {
  v1::Frame frame = quarter();
  frame.set_element_node(0, 27);
  EXPECT_TRUE(pictures_of(frame, {}).pictures.empty());
  EXPECT_EQ(draw_gap_map(frame).svg, "");
  EXPECT_TRUE(pull_in_profiles(frame).empty());
  frame = quarter();
  frame.mutable_element_node()->RemoveLast();
  EXPECT_TRUE(pictures_of(frame, {}).pictures.empty());
  frame = quarter();
  frame.set_dimension(2);
  EXPECT_TRUE(pictures_of(frame, {}).pictures.empty());
}

TEST(GapMap, SaysWhereTheGapIsLargestAndMarksEveryContact) {
  const GapMap map = draw_gap_map(quarter());
  EXPECT_EQ(map.contacts, 2);
  EXPECT_EQ(count_of(map.svg, "<circle class='contact'"), 2);
  EXPECT_DOUBLE_EQ(map.largest_gap_m, 20e-3);
  EXPECT_DOUBLE_EQ(map.largest_x_m, 0.6);
  EXPECT_DOUBLE_EQ(map.largest_y_m, 0.4);
  EXPECT_THAT(map.svg, HasSubstr("<title>10.0 mm</title>"));
}

TEST(GapMap, ABottomThatDoesNotFitIsNotDrawn) {
  v1::Frame frame = quarter();
  frame.mutable_bottom_gap_m()->RemoveLast();
  EXPECT_EQ(draw_gap_map(frame).svg, "");
  frame = quarter();
  frame.set_bottom_node(0, -1);
  EXPECT_EQ(draw_gap_map(frame).svg, "");
}

TEST(PullIn, IsMeasuredAtButtMiddleAndHeadOfTheSolidFace) {
  const auto profiles = pull_in_profiles(quarter());
  ASSERT_EQ(profiles.size(), 3u);
  EXPECT_EQ(profiles[0].name, "head");  // the middle row: the upper one is liquid
  EXPECT_NEAR(profiles[0].height_m, 0.1, 1e-8);
  EXPECT_NEAR(profiles[1].height_m, 0.075, 1e-8);
  EXPECT_EQ(profiles[2].height_m, 0.05) << "as dccast contraction";

  const double expected[3] = {4e-3, 5e-3, 6e-3};
  for (std::size_t k = 0; k < 3; ++k) {
    ASSERT_GE(profiles[k].x_m.size(), 3u);
    EXPECT_EQ(profiles[k].x_m.front(), 0.0);
    EXPECT_NEAR(profiles[k].x_m.back(), 0.6, 1e-12);
    for (std::size_t i = 0; i < profiles[k].x_m.size(); ++i) {
      EXPECT_NEAR(profiles[k].mould_m[i], 0.4, 1e-12);
      EXPECT_NEAR(profiles[k].pull_in_m(i), expected[k], 1e-9);
      EXPECT_NEAR(profiles[k].percent(i), 100.0 * expected[k] / 0.4, 1e-6);
    }
  }

  const std::string table = pull_in_table(profiles);
  EXPECT_EQ(count_of(table, "<tr><td>"), 3);
  EXPECT_EQ(count_of(table, "<td>394.0</td><td>6.0</td><td>1.5</td>"), 3);
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

TEST(Chart, LongNamesGoOnInFurtherRowsAndABandIsDrawnIn) {
  Chart chart;
  for (int i = 0; i < 4; ++i) chart.lines.push_back({"middle of the narrow face", {0, 1}, {0, 20}});
  chart.wanted = Chart::Wanted{35.0, 45.0, "the plant's band"};
  const std::string svg = svg_chart(chart);
  EXPECT_THAT(svg, HasSubstr("viewBox='0 -17 640 337'"));  // two rows
  EXPECT_EQ(count_of(svg, "class='wanted'"), 1);
  EXPECT_EQ(count_of(svg, "class='edge'"), 2);
  EXPECT_THAT(svg, HasSubstr(">40</text>"));  // the axis reaches the band above the curves
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
  EXPECT_EQ(count_of(page, "<svg class='slab'"), 3);
  EXPECT_EQ(count_of(page, "<g class='now'></g>"), 3) << "for the script of the page";
  EXPECT_EQ(count_of(page, "<svg class='map'"), 1);
  EXPECT_EQ(count_of(page, "<svg class='section'"), 0);
  for (const char* const part :
       {"Gap under the butt", "Pull-in of the wide face", "180 l/min/m", "Shell", "Sump",
        "Temperatures", "Heat through each face", "Contact with the block", "narrow face",
        "2 of 9 nodes", "<strong>100</strong> cm²"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* const absent : {"http://", "src=", "nan", "Gap along the bottom"})
    EXPECT_THAT(page, Not(HasSubstr(absent)));
}

TEST(ReportPage, SaysHowTheCurlLiesInThePlantsBand) {
  const std::string inside = report_page(v1::Job(), run_with(35, 45));
  EXPECT_THAT(inside, HasSubstr("corner has risen <strong>40.0 mm</strong>"));
  EXPECT_THAT(inside, HasSubstr("It is inside the plant&#39;s band, 35 to 45 mm."));
  EXPECT_EQ(count_of(inside, "class='wanted'"), 2);
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
        "<svg class='slab'", "<div class='sheet'>", "Curl against cast length", "Shell",
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
  EXPECT_EQ(count_of(page, "<path class='band'"), 2) << "in both charts of the curl";
  EXPECT_THAT(page, Not(HasSubstr("discretisation is not known")));
}

TEST(ReportPage, AFrameThatDoesNotFitIsSaidToBeAbsent) {
  v1::QueryResultResponse result = run_with(35, 45);
  result.mutable_frame()->clear_temperature_c();
  EXPECT_THAT(report_page(v1::Job(), result), HasSubstr("cannot be drawn"));
}

}  // namespace
}  // namespace dccast::client::render
