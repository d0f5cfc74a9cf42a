#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <sstream>
#include <utility>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/html_parts.hpp"
#include "client/html/pages.hpp"
#include "client/text/braille.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"
#include "client/text/watch_output.hpp"
#include "fake_service.hpp"
#include "json_reading.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/figures/plant_units.hpp"
#include "server/judging/run_judgement.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(Braille, AStraightLineRunsFromBelowToAbove) {
  EXPECT_EQ(braille_curve({0, 1}, 2, 1).front(), "⡠⠊");
  EXPECT_EQ(display_width(braille_curve({1, 2, 3}, 12, 1).front()), 12);
  EXPECT_EQ(braille_curve({}, 3, 2).size(), 2u);
}

TEST(Braille, LinesAreToldApartWithoutColour) {
  const BrailleLine level{{0, 1}, {1, 1}};
  const auto row_of = [&](const std::vector<BrailleLine>& lines) {
    const BrailleChart chart = braille_chart(lines, 12, 1);
    std::string text;
    for (const BrailleCell& cell : chart.cells[0]) text += cell.text;
    return text;
  };
  const BrailleLine nothing;
  EXPECT_NE(row_of({level}), row_of({nothing, level}));
  EXPECT_NE(row_of({nothing, level}), row_of({nothing, nothing, level}));
  EXPECT_NE(braille_sample(0), braille_sample(1));
  EXPECT_NE(braille_sample(1), braille_sample(2));
}

TEST(Numbers, ZeroHasNoSign) {
  EXPECT_EQ(fixed(-0.001, 2), "0.00");
  EXPECT_EQ(fixed(-0.0, 1), "0.0");
  EXPECT_EQ(mm(-1e-7, 2), "0.00");
  EXPECT_EQ(fixed(-0.006, 2), "-0.01");
}

TEST(Numbers, AnErrorHasTwoDigitsAndItsValueAsMany) {
  EXPECT_EQ(mm_decimals(0.21e-3), 2);
  EXPECT_EQ(mm_decimals(2.54e-3), 1);
  EXPECT_EQ(mm_decimals(9.96e-3), 0) << "which is rounded to 10";
  EXPECT_EQ(mm_decimals(NAN), 2) << "not known";
  EXPECT_EQ(mm_decimals(1e-9), 2) << "no curl is known better";
  EXPECT_EQ(mm_decimals(0.01168), 0);
}

v1::StepReport step_at(double time_s, double progress, double solver_s) {
  v1::StepReport step;
  step.set_time_s(time_s);
  step.set_progress(progress);
  step.set_solver_s(solver_s);
  return step;
}

TEST(Pace, OfTheHoldIsNoneOfTheRun) {
  Pace pace;
  pace.add(step_at(-30.0, 0.15, 0.1));
  EXPECT_FALSE(pace.left_s().has_value());
  pace.expected_s = 12.0;
  EXPECT_NEAR(pace.left_s().value(), 11.9, 1e-9);

  pace.add(step_at(0.0, 0.3, 0.2));
  EXPECT_NEAR(pace.left_s().value(), 11.8, 1e-9);
  pace.add(step_at(50.0, 0.65, 5.2));
  EXPECT_NEAR(pace.left_s().value(), 5.0, 1e-9) << "5 s for half of what follows the hold";
  pace.add(step_at(100.0, 1.0, 10.2));
  EXPECT_FALSE(pace.left_s().has_value());
}

TEST(Terminal, CutsByCodePoints) {
  EXPECT_EQ(cut_to("a°b⡠c", 3), "a°b");
  EXPECT_EQ(display_width("a°b⡠c"), 5);
}

TEST(Progress, PlainLinesWithoutATerminal) {
  std::ostringstream stream;
  Progress progress(stream, {});
  for (const v1::JobEvent& event : run_of(3)) progress.show(event);
  progress.finish();
  EXPECT_THAT(stream.str(), HasSubstr("step 2  t 2.00 s  cast 2.0 mm  corner +2.00 mm  2 it  eta"));
  EXPECT_THAT(stream.str(), HasSubstr("succeeded\n"));
  EXPECT_THAT(stream.str(), Not(HasSubstr("\033")));
  EXPECT_THAT(stream.str(), Not(HasSubstr("\r")));
}

TEST(Progress, OneRenewedLineOnATerminalNoWiderThanIt) {
  std::ostringstream stream;
  Progress progress(stream, {true, false, 40});
  for (const v1::JobEvent& event : run_of(3)) progress.show(event);
  progress.finish();
  std::istringstream pieces(stream.str());
  for (std::string piece; std::getline(pieces, piece, '\r');)
    EXPECT_TRUE(piece.find("step") == std::string::npos ||
                display_width(piece.substr(piece.find('K') + 1)) <= 40)
        << piece;
  EXPECT_THAT(stream.str(), HasSubstr("curl of corner"));
}

TEST(Progress, StepsComputedAgainReplaceTheFirstOnes) {
  std::ostringstream stream;
  Progress progress(stream, {});
  const auto events = run_of(5);
  for (int i = 2; i < 7; ++i) progress.show(events[static_cast<std::size_t>(i)]);
  v1::JobEvent resumed;
  resumed.mutable_resumed()->set_step(3);
  resumed.mutable_resumed()->set_time_s(3.0);
  progress.show(resumed);
  progress.show(events[5]);
  EXPECT_THAT(progress.history().time_s(), testing::ElementsAre(1, 2, 3, 4));
}

TEST(Progress, ARunBegunAnewHasOneCurve) {
  std::ostringstream stream;
  Progress progress(stream, {});
  const auto events = run_of(5);
  for (int i = 2; i < 6; ++i) progress.show(events[static_cast<std::size_t>(i)]);
  v1::JobEvent anew;
  anew.mutable_resumed()->set_time_s(-30.0);
  progress.show(anew);
  EXPECT_TRUE(progress.history().steps.empty());
  EXPECT_THAT(stream.str(), HasSubstr("started over"));
  for (const v1::JobEvent& event : events) progress.show(event);
  EXPECT_THAT(progress.history().time_s(), testing::ElementsAre(1, 2, 3, 4, 5));
}

TEST(WatchOutput, EveryLineHasTheKeysThatScriptsRelyOn) {
  WatchOutput output;
  for (const v1::JobEvent& event : run_of(2)) {
    const ReadJson line = ReadJson::parse(output.line(event).dump());
    for (const char* const key :
         {"sequence", "state", "step", "time_s", "cast_length_m", "iterations", "monitors"})
      EXPECT_TRUE(line.contains(key)) << key;
    EXPECT_EQ(line.dump().find('\n'), std::string::npos);
    if (!event.has_step()) continue;
    EXPECT_EQ(line["state"], "RUNNING");
    EXPECT_EQ(line["monitors"][0]["name"], "corner");
    EXPECT_DOUBLE_EQ(line["monitors"][0]["displacement_m"][1],
                     event.step().monitors(0).displacement_m(1));
  }
}

v1::Frame square() {
  v1::Frame frame;
  frame.set_dimension(2);
  frame.set_nodes_per_element(4);
  for (const double x : {0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0}) frame.add_node_m(x);
  for (const int node : {0, 1, 2, 3}) frame.add_element_node(node);
  for (const double t : {300.0, 50.0, 500.0, 680.0}) frame.add_temperature_c(t);
  for (const double u : {0.0, 0.0, -1e-3, 4e-3, 0.0, 0.0, 0.0, 0.0}) frame.add_displacement_m(u);
  for (const int node : {0, 1, 2, 0, 2, 3}) frame.add_skin_triangle(node);
  frame.set_solidus_c(620);
  frame.set_liquidus_c(649);
  for (const int node : {0, 1}) frame.add_bottom_node(node);
  for (const double gap : {0.0, 4e-3}) frame.add_bottom_gap_m(gap);
  for (const double pressure : {2e3, 0.0}) frame.add_bottom_pressure_pa(pressure);
  return frame;
}

TEST(ReportPage, HoldsEveryPartAndLoadsNothing) {
  v1::Job job;
  job.set_id("0123456789");
  job.set_title("<script>alert(1)</script>");
  job.set_state(v1::SUCCEEDED);
  v1::QueryResultResponse result;
  for (const v1::JobEvent& event : run_of(4))
    if (event.has_step()) *result.add_steps() = event.step();
  *result.mutable_frame() = square();
  result.mutable_case_()->mutable_schedule()->set_hold_s(60);
  judging::RunToJudge judged{
      .run = {{{result.steps().begin(), result.steps().end()}}, "run", result.case_()},
      .last_frame = result.frame()};
  const std::string page =
      report_page({.job = job, .result = result, .judgement = judging::judge_run(judged)});
  for (const char* const part :
       {"Curl against time", "Curl against cast length", "data-kind='slab'", "Gap along the bottom",
        "Contact pressure", "Checks of the run", "Hold before the block moves", "<td>60 s</td>",
        "Mechanics starts", "Coherency", "prefers-color-scheme"})
    EXPECT_THAT(page, HasSubstr(part));
  for (const char* const absent :
       {"<script>alert", "http://", "https://", "src=", ">nan", "nan mm"})
    EXPECT_THAT(page, Not(HasSubstr(absent)));
}

TEST(Page, HasItsModulesInsideWhereSomethingIsDrawn) {
  const std::string drawing = drawn("chart", Json{{"heading", "</script><b>"}});
  EXPECT_THAT(drawing, Not(HasSubstr("</script><b>"))) << "a text does not end its element";
  const std::string page = whole_page("", "", drawing);
  for (const char* const part :
       {"<script type='importmap'>{\"imports\":{", "\"chart.js\":\"data:text/javascript;base64,",
        "import 'report.js'", "<noscript>"})
    EXPECT_THAT(page, HasSubstr(part));
  EXPECT_THAT(whole_page("", "", "text"), Not(HasSubstr("<script")));
}

TEST(CastingDrawing, NamesWhatItShows) {
  v1::Case c;
  case_file::read_text(shipped::find(shipped::case_templates(), "start-3d")->text, "", c);
  case_file::apply_defaults(c);
  c.set_title("<b>");
  const std::string page = casting_page(c);
  for (const char* name : {"data-kind='casting'", "\"name\":\"mould contact\"",
                           "<h1>&lt;b&gt;</h1>", "speed 40 -&gt; 60 mm/min"})
    EXPECT_THAT(page, HasSubstr(name));
}

/// Points of the charts by the name of the line, in plant units with six decimals.
std::map<std::string, std::vector<double>> drawn_values(const v1::Case& complete) {
  std::map<std::string, std::vector<double>> values;
  for (const v1::Chart& chart : case_file::planned_charts(complete))
    for (const v1::Chart::Line& line : chart.lines())
      for (const double y : line.y())
        values[line.name()].push_back(
            1e-6 * std::round(1e6 * figures::plant_unit(chart.y().unit()).factor() * y));
  return values;
}

TEST(CastingDrawing, HasPointsOfWhatTheLeversLeave) {
  v1::Case c;
  case_file::read_text(shipped::find(shipped::case_templates(), "start-3d")->text, "", c);
  c.mutable_time()->set_end_s(250.0);
  case_file::apply_defaults(c);
  const auto range_of = [&](const std::string& line) {
    const std::vector<double> values = drawn_values(c).at(line);
    return std::pair(*std::ranges::min_element(values), *std::ranges::max_element(values));
  };
  EXPECT_EQ(range_of("casting speed"), std::pair(0.0, 60.0)) << "the block stands in the hold";
  EXPECT_EQ(range_of("water"), std::pair(0.0, 180.0));
  const auto shown = drawn_values(c).at("casting speed");
  EXPECT_TRUE(std::ranges::count(shown, 40.0)) << "mm/min";

  c.mutable_schedule()->mutable_casting_speed_factor()->set_value(0, 0.5);
  c.mutable_schedule()->mutable_water_flow_factor()->set_value(0, 0.1);
  EXPECT_EQ(range_of("casting speed"), std::pair(0.0, 30.0));
  EXPECT_EQ(range_of("water"), std::pair(0.0, 18.0));

  // A delay beyond the end leaves the first speed; pulses close the valve again and again.
  c.mutable_schedule()->set_casting_speed_shift_s(1000.0);
  EXPECT_EQ(range_of("casting speed"), std::pair(0.0, 20.0));
  v1::Water& water = *c.mutable_cooling()->mutable_water();
  water.set_pulse_period_s(20.0);
  water.set_pulse_end_s(c.time().end_s());
  const std::vector<double> pulsed = drawn_values(c).at("water");
  int closures = 0;
  for (std::size_t i = 1; i < pulsed.size(); ++i)
    closures += pulsed[i - 1] > 0.0 && pulsed[i] == 0.0;
  EXPECT_EQ(closures, 12) << "at 10 s, 30 s, ... 230 s";

  // A longer hold begins earlier.
  const std::size_t before = drawn_values(c).at("casting speed").size();
  EXPECT_GT(before, 100U);
  const auto zeros = [&] {
    const std::vector<double> values = drawn_values(c).at("casting speed");
    return std::ranges::count(values, 0.0);
  };
  const auto of_short_hold = zeros();
  c.mutable_schedule()->set_hold_s(600.0);
  EXPECT_GT(zeros(), of_short_hold);
}

TEST(ReportPage, OfAJobWithoutStepsSaysSo) {
  EXPECT_THAT(report_page({.job = v1::Job(), .result = v1::QueryResultResponse()}),
              HasSubstr("no step yet"));
}

}  // namespace
}  // namespace dccast::client
