#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/judging/comparison.hpp"
#include "server/judging/judged_comparison.hpp"

namespace dccast::judging {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

using Change = std::function<void(double time_s, v1::StepReport&)>;

/// A run of 200 steps of 1 s at 1 mm/s: curl [m], and what else is different in it.
JudgedRun run_of(const std::function<double(double)>& curl_m, const Change& change = {}) {
  JudgedRun run;
  for (int i = 0; i <= 200; ++i) {
    v1::StepReport step;
    step.set_step(i + 1);
    step.set_time_s(i);
    step.set_cast_length_m(1e-3 * i);
    step.mutable_section()->set_side_heat(1e5);
    step.mutable_section()->set_bottom_heat(2e4);
    step.set_contact_length_m(i < 60 ? 0.2 : 0.0);
    step.set_shell_at_water_line_m(4e-4 * i);
    if (change) change(i, step);
    v1::MonitorValue& corner = *step.add_monitors();
    corner.set_name("corner");
    corner.set_curl_m(curl_m(step.time_s()));
    corner.set_judged(true);
    run.steps.push_back(std::move(step));
  }
  return run;
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
  JudgedRun whole = run_of(rise_to(0.4)), part = run_of(rise_to(0.8));
  part.steps.resize(101);  // ends at 100 s, both half way
  const auto rows = curl_differences({whole, part});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].course.places.back(), 100.0);
  EXPECT_NEAR(rows[0].first_m, 0.2, 1e-12);
  EXPECT_NEAR(rows[0].end_m, 0.2, 1e-12);
}

/// Of two castings that end when their curl has settled, one ends at 120 s.
std::vector<JudgedRun> settled_castings() {
  JudgedRun early = run_of([](double time_s) { return std::min(0.3, 0.01 * time_s); });
  JudgedRun late = run_of(rise_to(0.4));
  early.steps.resize(121);
  for (JudgedRun* run : {&early, &late}) run->description.mutable_time()->set_settled_m_per_s(5e-6);
  return {early, late};
}

TEST(Comparison, ASettledCurlIsHeldToTheEndOfTheLongerRun) {
  const std::vector<JudgedRun> runs = settled_castings();
  for (const bool early_is_first : {true, false}) {
    const auto rows =
        curl_differences({runs[early_is_first ? 0 : 1], runs[early_is_first ? 1 : 0]});
    ASSERT_THAT(rows, SizeIs(1));
    EXPECT_EQ(rows[0].course.places.back(), 200.0);
    EXPECT_THAT(rows[0].course.places, SizeIs(201));
    EXPECT_NEAR(rows[0].end_m, early_is_first ? 0.1 : -0.1, 1e-12);
  }
}

/// It melted through before its curl began.
TEST(Comparison, ACurlThatHasNotBegunIsNotHeld) {
  std::vector<JudgedRun> runs = settled_castings();
  runs[0] = run_of([](double) { return 0.0; });
  runs[0].description = runs[1].description;
  runs[0].steps.resize(121);
  EXPECT_EQ(curl_differences(runs).at(0).course.places.back(), 120.0);
}

TEST(Comparison, ACurlThatMovesAtTheEndOfTheShorterRunIsNotHeld) {
  std::vector<JudgedRun> runs = settled_castings();
  runs[0].steps.resize(31);  // stopped while it rises
  EXPECT_EQ(curl_differences(runs).at(0).course.places.back(), 30.0);
}

TEST(Comparison, RunsOfDifferentSpeedAreComparedAtTheSameCastLength) {
  const JudgedRun slow = run_of(rise_to(0.4), [](double time_s, v1::StepReport& step) {
    step.set_cast_length_m(0.5e-3 * time_s);
  });
  const auto rows = curl_differences({run_of(rise_to(0.4)), slow});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_TRUE(rows[0].course.by_length);
  EXPECT_NEAR(rows[0].course.places.back(), 0.1, 1e-12);
  EXPECT_NEAR(rows[0].first_m, 0.2, 1e-12) << "at 100 mm, which the first has cast at 100 s";
  EXPECT_NEAR(rows[0].other_m, 0.4, 1e-12);
}

TEST(Comparison, IdenticalRunsHaveNoDifferenceAndNoCause) {
  const JudgedRun run = run_of(rise_to(0.01));
  const auto rows = curl_differences({run, run});
  ASSERT_THAT(rows, SizeIs(1));
  EXPECT_EQ(rows[0].verdict(), Verdict::no_difference);
  EXPECT_THAT(find_causes(run, run, rows[0]), IsEmpty());
  EXPECT_THAT(judge_comparison({run, run}, {}).sentences(),
              ElementsAre("run 2: no difference of 0.1 mm or more at 200 s."));
}

TEST(Comparison, ADifferenceBelowATenthOfAMillimetreDoesNotMatter) {
  JudgedRun first = run_of(rise_to(0.0100)), other = run_of(rise_to(0.01009));
  EXPECT_EQ(curl_differences({first, other}).at(0).verdict(), Verdict::no_difference);
  other = run_of(rise_to(0.01011));
  EXPECT_NE(curl_differences({first, other}).at(0).verdict(), Verdict::no_difference);
}

TEST(JudgedComparison, TwoQualitiesAndARunThatFailedAreSaidFirst) {
  JudgedRun first = run_of(rise_to(0.01)), other = run_of(rise_to(0.02));
  first.description = shipped_case("start-3d", v1::DRAFT);
  other.description = shipped_case("start-3d", v1::ENGINEERING);
  const v1::Judgement judgement = judge_comparison({first, other}, {});
  EXPECT_THAT(judgement.sentences(0), HasSubstr("different qualities"));
  EXPECT_THAT(judgement.sentences(1), HasSubstr("run 2, corner at 200 s: +10.0 mm"));

  other.description = first.description;
  other.failed = true;
  EXPECT_THAT(judge_comparison({first, other}, {}).sentences(0),
              HasSubstr("run 2 failed at 200 s and has no curl"));
}

TEST(JudgedComparison, ThreeFiguresOfARowAddUp) {
  const JudgedRun first = run_of(rise_to(2.0330e-3 + 4e-7)),
                  other = run_of(rise_to(4.5825e-3 + 1e-7));
  const v1::Judgement judgement = judge_comparison({first, other}, {});
  for (const v1::JudgementPart& part : judgement.parts()) {
    if (part.table().key() != "differences") continue;
    const auto shown = [](double m) { return std::round(1e6 * m); };
    const auto& rows = part.table().rows();
    EXPECT_EQ(shown(rows[1].cells(2).value()) - shown(rows[0].cells(2).value()),
              shown(rows[1].cells(4).value()));
  }
}

TEST(Comparison, ACauseIsNamedWithItsTimeAndSize) {
  const JudgedRun first = run_of(rise_to(0.01));
  const JudgedRun other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    if (time_s <= 100) step.mutable_section()->set_side_heat(0.78e5);
    if (time_s >= 60 && time_s < 72) step.set_contact_length_m(0.2);
    if (time_s > 190) step.mutable_section()->set_bottom_heat(0.0);  // after the curl: no cause
  });
  const auto rows = curl_differences({first, other});
  const auto causes = find_causes(first, other, rows.at(0));

  ASSERT_THAT(causes, SizeIs(2));
  EXPECT_EQ(causes[0].sentence, "less heat through the side until 100 s (-22 %)");
  EXPECT_EQ(causes[1].sentence, "contact with the block 12 s longer");
  EXPECT_LT(causes[0].onset, causes[1].onset);
  EXPECT_EQ(
      sentence(rows[0], causes),
      "corner at 200 s: -6.0 mm, of unknown error. Less heat through the side until 100 s (-22 %), "
      "contact with the block 12 s longer.");
}

TEST(Comparison, WhatDiffersAfterTheCurlIsNoCause) {
  const JudgedRun first = run_of(rise_to(0.01));
  const JudgedRun other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    if (time_s > 130) step.mutable_section()->set_side_heat(0.2e5);
  });
  EXPECT_THAT(find_causes(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, AFigureThatSwingsAboutTheOtherIsNoCause) {
  const JudgedRun first = run_of(rise_to(0.01));
  const JudgedRun other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    step.mutable_section()->set_side_heat(std::fmod(time_s, 10.0) < 5.0 ? 1.3e5 : 0.7e5);
  });
  EXPECT_THAT(find_causes(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, ALevelIsGivenWhereItDiffersMost) {
  const JudgedRun first = run_of(rise_to(0.01));
  const JudgedRun other = run_of(rise_to(0.004), [](double time_s, v1::StepReport& step) {
    step.set_shell_at_water_line_m(4e-4 * time_s +
                                   5e-3 * (time_s < 50 ? time_s / 50 : (200 - time_s) / 150));
  });
  const auto causes = find_causes(first, other, curl_differences({first, other}).at(0));
  ASSERT_THAT(causes, SizeIs(1));
  EXPECT_EQ(causes[0].sentence, "shell at the water line 20 -> 25 mm at 50 s");
}

/// 40 s before the block starts one casting has been held for 20 s and the other has just been
/// filled.
TEST(Comparison, CastingsOfDifferentAgeDoNotCompareBeforeTheBlockStarts) {
  const auto held = [](double hold_s) {
    JudgedRun run = run_of(
        [](double) { return 0.0; },
        [=](double time_s, v1::StepReport& step) {
          step.set_time_s(time_s - 60.0);
          // The shell over the block grows from the first metal on, and is held back to 12 mm
          // later.
          const double age_s = time_s - 60.0 + hold_s;
          step.set_bottom_shell_m(std::clamp(5e-4 * age_s, 0.0, time_s < 60.0 ? 1.0 : 12e-3));
        });
    run.description.mutable_schedule()->set_hold_s(hold_s);
    for (v1::StepReport& step : run.steps)
      step.mutable_monitors(0)->set_curl_m((hold_s > 50.0 ? 0.01 : 0.02) *
                                           std::clamp(step.time_s() / 100.0, 0.0, 1.0));
    return run;
  };
  const auto says = [&](const JudgedRun& first, const JudgedRun& other) {
    std::string all;
    for (const Cause& cause : find_causes(first, other, curl_differences({first, other}).at(0)))
      all += cause.sentence + "\n";
    return all;
  };
  const JudgedRun longer = held(60.0);
  JudgedRun shorter = held(40.0);
  EXPECT_THAT(says(longer, shorter), Not(HasSubstr("-")));

  // Of one age, the difference counts.
  shorter.description.mutable_schedule()->set_hold_s(60.0);
  EXPECT_THAT(says(longer, shorter), HasSubstr("shell over the block"));
}

/// The butt is solid through when it leaves the mould: there is no shell that could be thicker.
TEST(Comparison, AButtThatIsSolidThroughHasNoShell) {
  constexpr double half = 0.28;
  const auto butt_until = [](double end_s) {
    return [end_s](double time_s, v1::StepReport& step) {
      step.set_shell_at_water_line_m(time_s < end_s ? half : 0.05);
    };
  };
  JudgedRun first = run_of(rise_to(0.01), butt_until(60));
  JudgedRun other = run_of(rise_to(0.004), butt_until(90));
  for (JudgedRun* run : {&first, &other})
    run->description.mutable_section()->set_half_width_m(half);
  EXPECT_THAT(find_causes(first, other, curl_differences({first, other}).at(0)), IsEmpty());
}

TEST(Comparison, TheErrorOfADifferenceComesFromMeasuredPairs) {
  JudgedRun first = run_of(rise_to(0.0277)), other = run_of(rise_to(0.016));
  first.description = shipped_case("start-3d", v1::DRAFT);
  other.description = first.description;
  const auto row = curl_differences({first, other}).at(0);

  ASSERT_EQ(row.error_source, ErrorSource::table);
  EXPECT_NEAR(*row.error_m, 0.05 * 0.0277 + 0.2 * 0.0117, 1e-9);
  EXPECT_EQ(row.verdict(), Verdict::real);
  EXPECT_THAT(sentence(row, {}), HasSubstr("corner at 200 s: -11.7 ± 3.7 mm, real."));

  other.description = shipped_case("start-3d", v1::ENGINEERING);
  EXPECT_FALSE(curl_differences({first, other}).at(0).error_m.has_value())
      << "of two qualities nothing cancels";

  other.description = first.description;
  other.description.mutable_mesh()->set_columns(5);
  EXPECT_FALSE(curl_differences({first, other}).at(0).error_m.has_value()) << "a mesh of its own";
}

TEST(Comparison, TwoCastingsAtTwoQualitiesGiveTheirOwnError) {
  JudgedRun first = run_of(rise_to(0.0292)), other = run_of(rise_to(0.0172));
  JudgedRun first_draft = run_of(rise_to(0.0277)), other_draft = run_of(rise_to(0.0160));
  first.description = shipped_case("start-3d", v1::ENGINEERING);
  first_draft.description = shipped_case("start-3d", v1::DRAFT);
  for (auto [from, to] : {std::pair{&first, &other}, {&first_draft, &other_draft}}) {
    to->description = from->description;
    to->description.mutable_alloy()->set_liquidus_c(650.0);
  }
  const auto row = curl_differences({first, other}, {first_draft, other_draft}).at(0);
  EXPECT_EQ(row.error_source, ErrorSource::qualities);
  EXPECT_NEAR(*row.error_m, 3.0 * 0.0003, 1e-9) << "-12.0 and -11.7 mm";
  EXPECT_EQ(row.verdict(), Verdict::real);
}

TEST(Comparison, ADifferenceWithinItsErrorHasNoCause) {
  JudgedRun first = run_of(rise_to(0.0277));
  JudgedRun other = run_of(rise_to(0.0275), [](double, v1::StepReport& step) {
    step.mutable_section()->set_side_heat(0.9e5);
  });
  first.description = other.description = shipped_case("start-3d", v1::DRAFT);
  const auto row = curl_differences({first, other}).at(0);
  EXPECT_EQ(row.verdict(), Verdict::within_its_error);
  EXPECT_EQ(sentence(row, find_causes(first, other, row)),
            "corner at 200 s: -0.2 ± 1.4 mm, within its error.");
}

/// The charts of a judgement with this key.
std::vector<v1::Chart> charts_of(const v1::Judgement& judgement, const std::string& key) {
  std::vector<v1::Chart> charts;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.chart().key() == key) charts.push_back(part.chart());
  return charts;
}

TEST(JudgedComparison, DifferencesAreDrawnOverTheSizeOfTheirError) {
  JudgedRun first = run_of(rise_to(0.0277)), other = run_of(rise_to(0.0275));
  first.description = other.description = shipped_case("start-3d", v1::DRAFT);
  const CurlDifference row = curl_differences({first, other}).at(0);
  ASSERT_EQ(row.difference_m.size(), row.course.places.size());
  EXPECT_DOUBLE_EQ(row.difference_m.back(), row.end_m);

  const auto charts = charts_of(judge_comparison({first, other}, {}), "difference");
  ASSERT_THAT(charts, SizeIs(1));
  EXPECT_EQ(charts[0].heading(), "differences of corner");
  EXPECT_DOUBLE_EQ(charts[0].region().high(), *row.error_m);
  EXPECT_THAT(charts_of(judge_comparison({first, first}, {}), "difference"), IsEmpty())
      << "there is none";
}

TEST(JudgedComparison, TheTableHasNumbersWithTheirErrorsAndCodes) {
  JudgedRun first = run_of(rise_to(0.0277)), other = run_of(rise_to(0.016));
  first.description = other.description = shipped_case("start-3d", v1::DRAFT);
  const v1::Judgement judgement = judge_comparison({first, other}, {});
  const v1::Table* table = nullptr;
  for (const v1::JudgementPart& part : judgement.parts())
    if (part.table().key() == "differences") table = &part.table();
  ASSERT_NE(table, nullptr);
  ASSERT_EQ(table->rows_size(), 2);

  const auto& row = table->rows(1);
  EXPECT_EQ(table->columns(4).unit(), "m");
  EXPECT_NEAR(row.cells(4).value(), -0.0117, 1e-12);
  EXPECT_NEAR(row.cells(4).upper_error(), 0.05 * 0.0277 + 0.2 * 0.0117, 1e-9);
  EXPECT_EQ(row.cells(7).code(), "real");
  EXPECT_EQ(row.cells(8).code(), "table");
  EXPECT_THAT(judgement.sentences(0), HasSubstr("run 2, corner at 200 s: -11.7 ± 3.7 mm, real."));
}

TEST(JudgedComparison, ACurlThatIsUnknownIsNotDrawn) {
  const JudgedRun empty = run_of([](double) { return std::nan(""); });
  EXPECT_THAT(charts_of(judge_comparison({empty, empty}, {}), "curl"), IsEmpty());
}

TEST(JudgedComparison, ManyRunsAreDrawnCoarsely) {
  const std::vector<JudgedRun> runs(400, run_of(rise_to(0.01)));
  const auto charts = charts_of(judge_comparison(runs, {}), "curl");
  int points = 0;
  for (const auto& line : charts.at(0).lines()) points += line.x_size();
  EXPECT_LT(points, 61'000);
  EXPECT_EQ(*charts[0].lines(0).x().rbegin(), 200.0) << "the end is kept";
}

TEST(Comparison, KeysThatDifferAreNamedOnce) {
  std::vector<JudgedRun> runs(2);
  runs[0].description.set_title("one");
  runs[1].description.set_title("two");
  runs[0].description.mutable_mesh()->set_rows(20);
  runs[1].description.mutable_mesh()->set_rows(30);
  runs[1].description.add_monitor()->set_x_m(0.25);
  const auto keys = differing_keys(runs);
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].key, "mesh.rows");
  EXPECT_THAT(keys[0].values, testing::ElementsAre("20", "30"));
  EXPECT_EQ(keys[1].key, "monitor[0].x");
  EXPECT_THAT(keys[1].values, testing::ElementsAre("-", "\"0.25 m\""));
}

}  // namespace
}  // namespace dccast::judging
