#include <algorithm>
#include <cmath>
#include <cstring>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/frame_bytes.hpp"
#include "client/html/pages.hpp"
#include "client/text/table.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "server/judging/run_judgement.hpp"
#include "tests/support/quarter_frame.hpp"
#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::client {
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

/// Two triangles of its bottom stand for its skin.
v1::Frame quarter() {
  v1::Frame frame = support::quarter_frame();
  for (const int node : {0, 4, 1, 0, 3, 4}) frame.add_skin_triangle(node);
  for (const int node : {0, 1, 1, 2, 2, 5}) frame.add_skin_edge(node);
  return frame;
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
  const int counts[] = {27, 8, 8, 2, 3, 3};
  for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(number_at<std::int32_t>(bytes, i), counts[i]) << i;
  EXPECT_EQ(number_at<float>(bytes, 8), 250.0F);
  EXPECT_EQ(number_at<float>(bytes, 12 + 3 * 8), 0.6F) << "x of the corner of the butt";
  EXPECT_EQ(number_at<float>(bytes, 12 + 3 * 27 + 3 * 8 + 2), 20e-3F) << "it has risen";
  EXPECT_EQ(number_at<float>(bytes, 12 + 6 * 27 + 8), 100.0F);
  EXPECT_EQ(bytes.size(), 4u * (12 + 7 * 27 + 8 * 8 + 3 * 2 + 2 * 3));
}

TEST(FrameBytes, ASectionLiesInThePlaneOfWidthAndHeight) {
  v1::Frame frame;
  frame.set_dimension(2);
  frame.set_nodes_per_element(4);
  for (const double x : {0., 0., 1., 0., 1., 2., 0., 2.}) frame.add_node_m(x);
  for (const int node : {0, 1, 2, 3}) frame.add_element_node(node);
  for (const int node : {0, 1, 2, 0, 2, 3}) frame.add_skin_triangle(node);
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
    corner.set_judged(true);
    corner.set_temperature_c(300.0);
  }
  return result;
}

/// The report of a run that is judged as the server does it.
std::string report_of_run(const v1::Job& job, const v1::QueryResultResponse& result) {
  judging::RunToJudge judged{
      .run = {{{result.steps().begin(), result.steps().end()}}, "run", result.case_()}};
  if (result.has_frame()) judged.last_frame = result.frame();
  return report_page({.job = job, .result = result, .judgement = judging::judge_run(judged)});
}

TEST(ReportPage, OfAQuarterSlabHasItsPicturesAndThePlantsFigures) {
  const std::string page = report_of_run(v1::Job(), run_with(35, 45));
  EXPECT_EQ(count_of(page, "data-kind='slab'"), 1);
  EXPECT_EQ(count_of(page, "<div class='gap-map'></div>"), 1);
  for (const char* const part :
       {"Gap under the butt", "180 l/min/m", "Shell", "Sump", "Temperatures",
        "Heat through each face", "Contact with the block", "narrow face", ">20.00</td>",
        ">600</td>", ">400</td>", "<strong>1.00</strong> dm2"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* const absent : {"http://", "src=", ">nan", "nan mm", "Gap along the bottom"})
    EXPECT_THAT(page, Not(HasSubstr(absent)));
}

TEST(ReportPage, HasThePullInOfTheWideFaceAsFiguresAndAsLines) {
  v1::QueryResultResponse result;
  *result.mutable_case_() = frames::testing::quarter_slab();
  *result.mutable_frame() = frames::testing::cooled(frames::testing::hot_above);
  result.add_steps()->set_time_s(1000.0);
  const std::string page = report_of_run(v1::Job(), result);
  for (const char* const part :
       {"<h2>Pull-in of the wide face</h2>", "\"quantity\":\"pull-in\",\"unit\":\"m\"",
        ">pull-in, mm</th>", ">head</td>", ">butt</td>"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(report_of_run(v1::Job(), run_with(35, 45)), Not(HasSubstr("Pull-in")))
      << "of a frame whose case has no mould";
}

TEST(ReportPage, BothChartsOfTheCurlHaveThePlantsBand) {
  const std::string page = report_of_run(v1::Job(), run_with(35, 45));
  EXPECT_EQ(count_of(page, "\"region\":{\"low\":0.035,\"high\":0.045"), 2);
}

TEST(ReportPage, ItsFaceHasQualityDateAndVersion) {
  v1::Job job;
  job.mutable_end_time()->set_seconds(1'700'000'000);
  job.set_quality("engineering");
  const std::string page = report_of_run(job, run_with(35, 45));
  const std::string face = page.substr(page.find("<p class='kicker'>"), 400);
  EXPECT_THAT(face, HasSubstr("engineering"));
  EXPECT_THAT(face, HasSubstr("2023-11-1"));
  EXPECT_THAT(face, HasSubstr("dccast 1."));
  EXPECT_THAT(page, Not(HasSubstr("This is a draft")));

  job.set_quality("draft");
  EXPECT_THAT(report_of_run(job, run_with(35, 45)), HasSubstr("This is a draft: "));
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
  const std::string page = report_of_run(job, result);
  std::size_t at = 0;
  for (const char* const part :
       {"<div class='first'>", "<p class='answer'>", "has risen 40.0 mm", "<p class='cause'>",
        "between 50 s and 150 s", "too hot", "<div class='tiles'>", "Curl against time",
        "time zero is when the bottom block starts", "Recipe", "data-kind='slab'",
        "<div class='histories'>", "Curl against cast length", "Casting speed", "Water", "Shell",
        "Smallest shell thickness", "Gap under the butt", "<div class='evidence'>"}) {
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
  const std::string page = report_of_run(job, run_with(35, 45));
  const auto answer = page.find("has risen");
  EXPECT_LT(page.find("<span class='state failed'>1 danger</span>"), answer);
  EXPECT_LT(page.find("The run failed: worker hung: no step &lt;for&gt; an hour"), answer);
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
  EXPECT_THAT(report_of_run(v1::Job(), result), HasSubstr("<em>-0 +5.60 mm</em>"));
}

TEST(ReportPage, ACurlWithErrorsHasItsBand) {
  v1::QueryResultResponse result = run_with(35, 45);
  set_errors(0.04, 0.04, result);
  const std::string page = report_of_run(v1::Job(), result);
  EXPECT_THAT(page, HasSubstr("<em>± 1.60 mm</em>"));
  EXPECT_THAT(page, HasSubstr("the band of the case&#39;s quality"));
  EXPECT_EQ(count_of(page, "\"low\":[0.00768,"), 2) << "in both charts of the curl";
  EXPECT_THAT(page, Not(HasSubstr("discretisation is not known")));
}

TEST(ReportPage, AFrameThatDoesNotFitIsSaidToBeAbsent) {
  v1::QueryResultResponse result = run_with(35, 45);
  result.mutable_frame()->clear_temperature_c();
  EXPECT_THAT(report_page({.job = v1::Job(), .result = result}), HasSubstr("cannot be drawn"));
}

}  // namespace
}  // namespace dccast::client
