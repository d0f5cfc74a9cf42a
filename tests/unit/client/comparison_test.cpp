#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "client/html/pages.hpp"
#include "client/html/svg_chart.hpp"
#include "client/model/comparison.hpp"
#include "client/text/comparison_text.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

using Change = std::function<void(double time_s, v1::StepReport&)>;

/// A run of 200 steps of 1 s at 1 mm/s: curl [m], and what else is different in it.
Answer run_of(const std::function<double(double)>& curl_m, const Change& change = {}) {
  Answer answer;
  for (int i = 0; i <= 200; ++i) {
    v1::StepReport step;
    step.set_step(i + 1);
    step.set_time_s(i);
    step.set_cast_length_m(1e-3 * i);
    step.set_side_heat_w_per_m(1e5);
    step.set_bottom_heat_w_per_m(2e4);
    step.set_contact_length_m(i < 60 ? 0.2 : 0.0);
    step.set_shell_at_water_line_m(4e-4 * i);
    if (change) change(i, step);
    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.add_displacement_m(0.0);
    corner.add_displacement_m(curl_m(step.time_s()));
    answer.history.add(step);
  }
  return answer;
}

/// Rises from 40 to 160 s to its end [m].
std::function<double(double)> rise_to(double end_m) {
  return [end_m](double time_s) { return end_m * std::clamp((time_s - 40) / 120, 0.0, 1.0); };
}

/// A shipped case with all its defaults.
v1::Case shipped_case(const std::string& name, v1::Quality quality) {
  for (const shipped::ShippedText& text : shipped::case_templates()) {
    if (text.name != name) continue;
    v1::Case description;
    EXPECT_TRUE(case_file::read_text(text.text, name, description).ok());
    description.set_quality(quality);
    case_file::apply_quality(description);
    case_file::apply_defaults(description);
    return description;
  }
  ADD_FAILURE() << name;
  return {};
}

TEST(Comparison, DifferencesAreTakenAtTheSameTime) {
  const auto rows = curl_differences({run_of(rise_to(0.4)), run_of([](double time_s) {
                                        return time_s == 20 ? 0.7 : rise_to(0.5)(time_s);
                                      })});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_FALSE(rows[0].course.by_length);
  EXPECT_NEAR(rows[0].end_m, 0.1, 1e-12);
  EXPECT_NEAR(rows[0].largest_m, 0.7, 1e-12);
  EXPECT_EQ(rows[0].largest_at, 20.0);
}

TEST(Comparison, ARunThatEndsEarlierIsComparedUpToItsEnd) {
  Answer whole = run_of(rise_to(0.4)), part = run_of(rise_to(0.8));
  part.history.rewind(101);  // ends at 100 s, both half way
  const auto rows = curl_differences({whole, part});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].course.at.back(), 100.0);
  EXPECT_NEAR(rows[0].first_m, 0.2, 1e-12);
  EXPECT_NEAR(rows[0].end_m, 0.2, 1e-12);
}

TEST(Comparison, RunsOfDifferentSpeedAreComparedAtTheSameCastLength) {
  const Answer slow = run_of(rise_to(0.4), [](double time_s, v1::StepReport& step) {
    step.set_cast_length_m(0.5e-3 * time_s);
  });
  const auto rows = curl_differences({run_of(rise_to(0.4)), slow});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_TRUE(rows[0].course.by_length);
  EXPECT_NEAR(rows[0].course.at.back(), 0.1, 1e-12);
  EXPECT_NEAR(rows[0].first_m, 0.2, 1e-12) << "at 100 mm, which the first has cast at 100 s";
  EXPECT_NEAR(rows[0].other_m, 0.4, 1e-12);
}

TEST(Comparison, IdenticalRunsHaveNoDifferenceAndNoCause) {
  const Answer run = run_of(rise_to(0.01));
  const auto rows = curl_differences({run, run});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_TRUE(rows[0].none());
  EXPECT_THAT(causes_of(run, run, rows[0]), IsEmpty());
  EXPECT_EQ(sentence(rows[0], {}), "corner: no difference.");
}

TEST(Comparison, ACauseIsNamedWithItsTimeAndSize) {
  const Answer first = run_of(rise_to(0.01));
  const Answer other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    if (time_s <= 100) step.set_side_heat_w_per_m(0.78e5);
    if (time_s >= 60 && time_s < 72) step.set_contact_length_m(0.2);
    if (time_s > 190) step.set_bottom_heat_w_per_m(0.0);  // after the curl: no cause
  });
  const auto rows = curl_differences({first, other});
  const auto causes = causes_of(first, other, rows.at(0));
  ASSERT_THAT(causes, SizeIs(2));
  EXPECT_EQ(causes[0].sentence, "less heat through the side until 100 s (-22 %)");
  EXPECT_EQ(causes[1].sentence, "contact with the block 12 s longer");
  EXPECT_LT(causes[0].onset, causes[1].onset);
  EXPECT_EQ(sentence(rows[0], causes),
            "corner: -6.0 mm, of unknown error. Less heat through the side until 100 s (-22 %), "
            "contact with the block 12 s longer.");
}

TEST(Comparison, WhatDiffersAfterTheCurlIsNoCause) {
  const Answer first = run_of(rise_to(0.01));
  const Answer other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    if (time_s > 130) step.set_side_heat_w_per_m(0.2e5);
  });
  EXPECT_THAT(causes_of(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, AFigureThatSwingsAboutTheOtherIsNoCause) {
  const Answer first = run_of(rise_to(0.01));
  const Answer other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    step.set_side_heat_w_per_m(std::fmod(time_s, 10.0) < 5.0 ? 1.3e5 : 0.7e5);
  });
  EXPECT_THAT(causes_of(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, ALevelIsGivenWhereItDiffersMost) {
  const Answer first = run_of(rise_to(0.01));
  const Answer other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    step.set_shell_at_water_line_m(4e-4 * time_s +
                             5e-3 * (time_s < 50 ? time_s / 50 : (200 - time_s) / 150));
  });
  const auto causes = causes_of(first, other, curl_differences({first, other}).at(0));
  ASSERT_THAT(causes, SizeIs(1));
  EXPECT_EQ(causes[0].sentence, "shell at the water line 20 -> 25 mm at 50 s");
}

/// The butt is solid through when it leaves the mould: there is no shell that could be thicker.
TEST(Comparison, AButtThatIsSolidThroughHasNoShell) {
  constexpr double half = 0.28;
  const auto butt_until = [](double end_s) {
    return [end_s](double time_s, v1::StepReport& step) {
      step.set_shell_at_water_line_m(time_s < end_s ? half : 0.05);
    };
  };
  Answer first = run_of(rise_to(0.01), butt_until(60));
  Answer other = run_of(rise_to(0.004), butt_until(90));
  for (Answer* answer : {&first, &other})
    answer->description.mutable_section()->set_half_width_m(half);
  EXPECT_THAT(causes_of(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, TheErrorOfADifferenceComesFromMeasuredPairs) {
  Answer first = run_of(rise_to(0.0277)), other = run_of(rise_to(0.016));
  first.description = shipped_case("start-3d", v1::DRAFT);
  other.description = first.description;
  const auto row = curl_differences({first, other}).at(0);
  ASSERT_EQ(row.error_from, ErrorSource::table);
  EXPECT_NEAR(*row.error_m, 0.05 * 0.0277 + 0.2 * 0.0117, 1e-9);
  EXPECT_TRUE(row.real());
  EXPECT_THAT(sentence(row, {}), HasSubstr("corner: -11.7 ± 3.7 mm, real."));
  other.description = shipped_case("start-3d", v1::ENGINEERING);
  EXPECT_FALSE(curl_differences({first, other}).at(0).error_m.has_value())
      << "of two qualities nothing cancels";
  other.description = first.description;
  other.description.mutable_mesh()->set_columns(5);
  EXPECT_FALSE(curl_differences({first, other}).at(0).error_m.has_value()) << "a mesh of its own";
}

TEST(Comparison, TwoCastingsAtTwoQualitiesGiveTheirOwnError) {
  Answer first = run_of(rise_to(0.0292)), other = run_of(rise_to(0.0172));
  Answer first_draft = run_of(rise_to(0.0277)), other_draft = run_of(rise_to(0.0160));
  first.description = shipped_case("start-3d", v1::ENGINEERING);
  first_draft.description = shipped_case("start-3d", v1::DRAFT);
  for (auto [from, to] : {std::pair{&first, &other}, {&first_draft, &other_draft}}) {
    to->description = from->description;
    to->description.mutable_alloy()->set_liquidus_c(650.0);
  }
  const auto row = curl_differences({first, other}, {first_draft, other_draft}).at(0);
  EXPECT_EQ(row.error_from, ErrorSource::qualities);
  EXPECT_NEAR(*row.error_m, 3.0 * 0.0003, 1e-9) << "-12.0 and -11.7 mm";
  EXPECT_TRUE(row.real());
}

TEST(Comparison, ADifferenceWithinItsErrorHasNoCause) {
  Answer first = run_of(rise_to(0.0277));
  Answer other = run_of(rise_to(0.0275),
                        [](double, v1::StepReport& step) { step.set_side_heat_w_per_m(0.9e5); });
  first.description = other.description = shipped_case("start-3d", v1::DRAFT);
  const auto row = curl_differences({first, other}).at(0);
  EXPECT_FALSE(row.real());
  EXPECT_EQ(sentence(row, causes_of(first, other, row)),
            "corner: -0.2 ± 1.4 mm, within its error.");
}

TEST(Comparison, DifferencesAreDrawnOverTheSizeOfTheirError) {
  Answer first = run_of(rise_to(0.0277)), other = run_of(rise_to(0.0275));
  first.description = other.description = shipped_case("start-3d", v1::DRAFT);
  const std::vector<Answer> answers{first, other};
  const auto differences = curl_differences(answers);
  const CurlDifference& row = differences.at(0);
  ASSERT_EQ(row.apart_m.size(), row.course.at.size());
  EXPECT_DOUBLE_EQ(row.apart_m.back(), row.end_m);
  const std::string page = render::comparison_page(answers, differences);
  EXPECT_THAT(page, HasSubstr("Differences of corner"));
  EXPECT_THAT(page, HasSubstr("within the error of a difference at the end"));
  EXPECT_THAT(render::comparison_page({first, first}, curl_differences({first, first})),
              Not(HasSubstr("Differences of corner")))
      << "there is none";
}

TEST(Comparison, TheTextFitsThePage) {
  Answer first = run_of(rise_to(0.01)), other = run_of(rise_to(0.004));
  other.name = first.name = "run";
  v1::Curve& speed = *other.description.mutable_schedule()->mutable_casting_speed_m_per_s();
  for (int i = 0; i < 40; ++i) speed.add_at(i), speed.add_value(1e-3);
  const auto differences = curl_differences({first, other});
  const std::string text = render::comparison_text({first, other}, differences, {.columns = 100});
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    EXPECT_LE(render::display_width(line), 120) << line;
  EXPECT_THAT(text, HasSubstr("run 2, corner: -6.0 mm"));
}

TEST(Comparison, AChartWithoutPointsIsNotDrawn) {
  Answer empty = run_of([](double) { return std::nan(""); });
  const std::vector<Answer> answers{empty, empty};
  EXPECT_THAT(render::comparison_text(answers, curl_differences(answers), {.columns = 100}),
              Not(HasSubstr("curl of corner")));
  EXPECT_THAT(render::comparison_page(answers, curl_differences(answers)),
              Not(HasSubstr("<svg class='chart'")));
}

TEST(Comparison, KeysThatDifferAreNamedOnce) {
  std::vector<Answer> answers(2);
  answers[0].description.set_title("one");
  answers[1].description.set_title("two");
  answers[0].description.mutable_mesh()->set_rows(20);
  answers[1].description.mutable_mesh()->set_rows(30);
  answers[1].description.add_monitor()->set_x_m(0.25);
  const auto keys = differing_keys(answers);
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].key, "mesh.rows");
  EXPECT_THAT(keys[0].values, testing::ElementsAre("20", "30"));
  EXPECT_EQ(keys[1].key, "monitor[0].x");
  EXPECT_THAT(keys[1].values, testing::ElementsAre("-", "\"0.25 m\""));
}

}  // namespace
}  // namespace dccast::client
