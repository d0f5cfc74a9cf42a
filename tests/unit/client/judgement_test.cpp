#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "client/html/judgement_parts.hpp"
#include "client/model/judgement_json.hpp"
#include "client/text/judgement_text.hpp"
#include "json_reading.hpp"
#include "proto/figures/rounding.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

/// A table of one figure with its error, a code and a value of a case.
v1::Table curl_table() {
  v1::Table table;
  table.set_key("curls");
  table.set_heading("curl at the end");
  auto& name = *table.add_columns();
  name.set_key("monitor");
  name.set_heading("monitor");
  auto& curl = *table.add_columns();
  curl.set_key("curl");
  curl.set_heading("curl");
  curl.set_unit("m");
  curl.set_resolution(1e-4);
  curl.set_has_error(true);
  auto& place = *table.add_columns();
  place.set_key("at");
  place.set_heading("at");
  auto& source = *table.add_columns();  // without a heading: for programs
  source.set_key("source");
  return table;
}

void add_row(v1::Table& table, const std::string& name, double curl_m, double lower_m,
             double upper_m) {
  auto& row = *table.add_rows();
  row.add_cells()->set_text(name);
  v1::Cell& curl = *row.add_cells();
  curl.set_value(curl_m);
  curl.set_lower_error(lower_m);
  curl.set_upper_error(upper_m);
  v1::Cell& place = *row.add_cells();
  place.set_value(0.08);
  place.set_unit("m");
  row.add_cells()->set_code("of_a_table");
}

TEST(JudgementText, NumbersAreConvertedAndRoundedByTheRenderer) {
  v1::Table table = curl_table();
  add_row(table, "corner", 0.035512, 0.0014, 0.0014);
  EXPECT_EQ(table_text(table),
            "curl at the end\n"
            "monitor  curl mm  ± mm  at\n"
            "corner      35.5   1.4  80 mm\n");
  EXPECT_THAT(table_text(table, {.capitals = true, .headings = false}),
              testing::StartsWith("MONITOR  CURL mm  ± mm  AT\n"));
}

TEST(JudgementText, AnErrorMayBeOneSided) {
  v1::Table table = curl_table();
  add_row(table, "corner", 0.0355, 0.0, 0.0039);
  EXPECT_THAT(table_text(table), HasSubstr("35.5  -0 +3.9"));
  EXPECT_THAT(table_part(table), HasSubstr("35.5, -0 +3.9"));
}

TEST(JudgementText, ErrorsInTextAndReportAreThoseOfAllRenderers) {
  std::ifstream file(DCCAST_FIGURES);
  const auto examples = nlohmann::json::parse(file);
  int shown = 0;
  for (const auto& example : examples.at("curls")) {
    if (!example.contains("upper_m")) continue;
    const double lower_m = example["lower_m"], upper_m = example["upper_m"];
    const int decimals = figures::mm_decimals(std::max(lower_m, upper_m));
    v1::Table table = curl_table();
    table.mutable_columns(1)->set_resolution(1e-3 * std::pow(10.0, -decimals));
    add_row(table, "corner", example["curl_m"], lower_m, upper_m);

    std::string text = example["text"];
    text.resize(text.size() - std::string(" mm").size());
    EXPECT_THAT(table_part(table), HasSubstr(">" + text + "<"));
    ++shown;
  }
  EXPECT_GT(shown, 10);
}

TEST(JudgementText, AFigureThatIsNotKnownIsEmptyAndZeroHasNoSign) {
  v1::Table table = curl_table();
  table.add_rows()->add_cells()->set_text("middle");
  add_row(table, "corner", -0.00000001, 0.0001, 0.0001);
  EXPECT_THAT(table_text(table), HasSubstr("\nmiddle\n"));
  EXPECT_THAT(table_text(table), Not(HasSubstr("-0.0")));
}

TEST(JudgementText, WideTextsAreCutToThePage) {
  v1::Table table;
  for (const char* key : {"key", "first", "other"}) {
    auto& column = *table.add_columns();
    column.set_key(key);
    column.set_heading(key);
  }
  auto& row = *table.add_rows();
  for (int i = 0; i < 3; ++i) row.add_cells()->set_case_value(std::string(300, 'x'));
  std::istringstream lines(table_text(table));
  for (std::string line; std::getline(lines, line);) EXPECT_LE(display_width(line), 120) << line;
}

TEST(JudgementText, ARangeReadsFromTo) {
  v1::Table table = curl_table();
  v1::Cell& curl = *table.add_rows()->add_cells();
  curl.set_text("corner");
  v1::Cell& range = *table.mutable_rows(0)->add_cells();
  range.set_value(0.0312);
  range.set_until(0.1445);
  EXPECT_THAT(table_text(table), HasSubstr("31.2 to 144.5"));
  v1::Judgement judgement;
  *judgement.add_parts()->mutable_table() = table;
  EXPECT_THAT(judgement_json(judgement).dump(), HasSubstr("\"curl_until_m\":0.1445"));
}

TEST(JudgementText, BarsHaveOneScale) {
  v1::Table table;
  for (const char* key : {"low", "high"}) {
    auto& column = *table.add_columns();
    column.set_key(key);
    column.set_heading(key);
    column.set_unit("m");
    column.set_has_bars(true);
  }
  for (const double size : {0.002, 0.001}) {
    auto& row = *table.add_rows();
    row.add_cells()->set_value(-size);
    row.add_cells()->set_value(size);
  }
  const std::string text = table_text(table);

  EXPECT_THAT(text, HasSubstr("=======|======="));
  EXPECT_THAT(text, HasSubstr("   ====|===="));
}

TEST(JudgementText, ABarOfARangeOnOneSideOfZeroDoesNotTouchTheAxis) {
  v1::Table table;
  v1::Table::Column& band = *table.add_columns();
  band.set_key("band");
  band.set_heading("band");
  band.set_unit("m");
  band.set_resolution(1e-3);
  band.set_has_bars(true);
  v1::Cell& cell = *table.add_rows()->add_cells();
  cell.set_value(0.035);
  cell.set_until(0.070);
  EXPECT_THAT(table_text(table), HasSubstr("|   ===="));
}

TEST(JudgementText, SentencesStandBelowOnATerminalAndFirstOnAPage) {
  v1::StudyJudgement study;
  study.mutable_study()->set_id("id");
  study.mutable_study()->set_title("A start");
  v1::Judgement& judgement = *study.mutable_judgement();
  judgement.set_heading("9 runs: 9 valid");
  judgement.add_sentences("It is so.");
  *judgement.add_parts()->mutable_table() = curl_table();
  add_row(*judgement.mutable_parts(0)->mutable_table(), "corner", 0.0355, 0.0, 0.0039);
  const std::string text = study_judgement_text(study, {.columns = 100});
  EXPECT_THAT(text, testing::StartsWith("study id: A start\n9 runs: 9 valid\n\ncurl at the end\n"));
  EXPECT_THAT(text, testing::EndsWith("\n\nIt is so.\n"));
  EXPECT_EQ(sentences_part(judgement), "<p class='answer'>It is so.</p>");

  judgement.mutable_parts(0)->set_place(v1::JudgementPart::PAGE);
  EXPECT_THAT(study_judgement_text(study, {.columns = 100}), Not(HasSubstr("corner")));
  EXPECT_THAT(judgement_parts(judgement), HasSubstr("corner"));
}

TEST(JudgementJson, MembersAreNamedByColumnAndUnit) {
  v1::Judgement judgement;
  v1::Table& table = *judgement.add_parts()->mutable_table();
  table = curl_table();
  add_row(table, "corner", 0.0355, 0.0014, 0.0014);
  add_row(table, "middle", 0.0355, 0.0, 0.0039);
  const ReadJson json = ReadJson::parse(judgement_json(judgement).dump());

  EXPECT_EQ(json["curls"][0]["monitor"], "corner");
  EXPECT_EQ(json["curls"][0]["curl_m"], 0.0355);
  EXPECT_EQ(json["curls"][0]["curl_error_m"], 0.0014);
  EXPECT_EQ(json["curls"][0]["at_m"], 0.08);
  EXPECT_EQ(json["curls"][0]["source"], "of_a_table");
  EXPECT_EQ(json["curls"][1]["curl_lower_error_m"], 0.0);
  EXPECT_EQ(json["curls"][1]["curl_upper_error_m"], 0.0039);
}

TEST(JudgementJson, OfAStudyStandsBesideItsFigures) {
  v1::StudyJudgement answer;
  answer.mutable_judgement()->add_sentences("It is so.");
  answer.mutable_result()->add_monitors("corner");
  const ReadJson json = ReadJson::parse(study_json(answer).dump());
  EXPECT_EQ(json["monitors"][0], "corner");
  EXPECT_EQ(json["judgement"]["sentences"][0], "It is so.");
}

TEST(JudgementChart, HasItsLinesInTheDataOfThePageWithSixDigits) {
  v1::Chart chart;
  chart.set_heading("curl of the corner");
  chart.mutable_x()->set_unit("m");
  v1::Chart::Line& line = *chart.add_lines();
  for (const double x : {0.1, 0.2}) line.add_x(x);
  for (const double y : {0.0212345678, static_cast<double>(NAN)}) line.add_y(y);
  line.set_is_dotted(true);
  const std::string html = chart_figure(chart);
  for (const char* const part : {"<h2>Curl of the corner</h2>", "\"unit\":\"m\"", "\"x\":[0.1,0.2]",
                                 "\"y\":[0.0212346,null]", "\"is_dotted\":true"})
    EXPECT_THAT(html, HasSubstr(part));
}

TEST(JudgementChart, ItsNoteIsItsCaption) {
  v1::Judgement judgement;
  v1::Chart& chart = *judgement.add_parts()->mutable_chart();
  chart.set_note("Below <the> level.");

  const std::string html = judgement_parts(judgement);
  EXPECT_THAT(html, HasSubstr("<div class='caption'>Below &lt;the&gt; level.</div>"));
}

TEST(JudgementChart, ALongLineIsThinnedAndKeepsItsEnds) {
  v1::Chart chart;
  v1::Chart::Line& line = *chart.add_lines();
  for (int i = 0; i <= 1000; ++i) {
    line.add_x(i);
    line.add_y(0.0);
  }
  const std::string html = chart_figure(chart);
  EXPECT_THAT(html, HasSubstr("\"x\":[0.0,3.0,6.0"));
  EXPECT_THAT(html, HasSubstr("999.0,1000.0]"));
}

}  // namespace
}  // namespace dccast::client
