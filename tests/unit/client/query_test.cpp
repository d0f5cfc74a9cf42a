#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/text/braille.hpp"
#include "client/text/judgement_text.hpp"
#include "client/text/terminal.hpp"
#include "client_run.hpp"
#include "fake_service.hpp"
#include "json_reading.hpp"
#include "proto/case_file/shipped.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

struct Query : testing::Test {
  FakeService service;
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("dccast_query_" + std::to_string(::getpid()));
  std::string file = (folder / "my.toml").string();

  void SetUp() override {
    std::filesystem::create_directory(folder);
    std::ofstream(file) << shipped::case_templates().back().text;
    service.job.set_id("job");
    service.job.set_state(v1::SUCCEEDED);
    for (const v1::JobEvent& event : run_of(3))
      if (event.has_step()) *service.result.add_steps() = event.step();
  }
  void TearDown() override { std::filesystem::remove_all(folder); }
  Result run(std::vector<std::string> arguments) {
    return dccast(std::move(arguments), service.address());
  }
};

TEST_F(Query, AnswersWithTheCurlOfEveryMonitor) {
  const Result result = run({"query", file, "--set", "mesh.rows=30", "--keep"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, testing::StartsWith("changed: mesh.rows = 30\ncurls at the end\n"));
  EXPECT_THAT(result.out, testing::ContainsRegex("corner +3\\.00"));
  EXPECT_THAT(result.out, HasSubstr("corner has risen 3.0 mm since the block started"));
  EXPECT_THAT(result.err, HasSubstr("solver 0.25 s"));
  EXPECT_TRUE(service.queried.keep());
  EXPECT_EQ(service.queried.case_().mesh().rows(), 30);
  EXPECT_EQ(service.queried.changes(0).key(), "mesh.rows");
}

TEST_F(Query, FindingsComeFirst) {
  v1::Finding& finding = *service.result.add_findings();
  finding.set_severity(v1::Finding::WARNING);
  finding.set_code("no_superheat");
  finding.set_message("The metal is poured at its liquidus.");
  finding.set_remedy("Pour hotter.");
  EXPECT_THAT(run({"query", file}).out,
              testing::StartsWith("warning: no_superheat: The metal is poured at its liquidus. "
                                  "Pour hotter.\ncurls at the end"));
}

TEST_F(Query, JsonHasTheHistory) {
  const ReadJson json = ReadJson::parse(run({"query", "--json", file}).out);
  EXPECT_EQ(json["monitors"][0]["curl_m"].size(), 3u);
  EXPECT_TRUE(json["monitors"][0]["end_upper_error_m"].is_null());
  EXPECT_EQ(json["state"], "SUCCEEDED");
}

TEST_F(Query, FaultsOfTheServerStandInTheFile) {
  v1::Fault& fault = *service.verdict.add_faults();
  fault.set_field("mesh.rows");
  fault.set_message("too many");
  const Result result = run({"query", "--set", "mesh.rows=30", file});
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr("--set mesh.rows, column 11: mesh.rows: too many"));
}

TEST_F(Query, ARunThatFailedHasItsOwnExitCode) {
  service.job.set_state(v1::FAILED);
  EXPECT_EQ(run({"query", file}).code, 3);
}

TEST(ShownValue, IsInTheUnitsOfThePit) {
  EXPECT_EQ(shown_value("[[\"60 s\", \"0.0006666666666666668 m/s\"]]"), "[[60 s, 40 mm/min]]");
  EXPECT_EQ(shown_value("\"9.81 m/s2\""), "9.81 m/s2");
}

TEST_F(Query, AComparisonNamesKeysAndDifferences) {
  std::ofstream(folder / "other.toml")
      << shipped::case_templates().back().text << "\n[validity]\nmaximum_slip = \"7 mm\"\n";
  const Result result = run({"compare", file, (folder / "other.toml").string()});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("curl of corner"));
  EXPECT_THAT(result.out, HasSubstr("no difference"));
  EXPECT_THAT(run({"compare", file, file}).out, HasSubstr("the cases do not differ"));

  const std::string page = (folder / "page.html").string();
  EXPECT_EQ(run({"compare", "-o", page, file, "job"}).code, 0);

  std::ostringstream text;
  text << std::ifstream(page).rdbuf();
  EXPECT_THAT(text.str(), HasSubstr("data-kind='chart'"));
  EXPECT_EQ(run({"compare", "-o", page, file, "job"}).code, 2) << "it would be overwritten";

  const ReadJson json = ReadJson::parse(run({"compare", "--json", file, "job"}).out);
  EXPECT_EQ(json["runs"].size(), 2u);
  EXPECT_EQ(json["differences"][1]["difference_m"], 0.0);
  EXPECT_EQ(json["differences"][1]["verdict"], "no_difference");
}

TEST(Braille, LinesOverEachOtherKeepTheirOwnLength) {
  const auto chart = braille_chart({{{0, 10}, {0, 1}}, {{0, 5}, {1, 1}}}, 10, 2);
  EXPECT_EQ(chart.low, 0.0);
  EXPECT_EQ(chart.high, 1.0);
  ASSERT_EQ(chart.cells.size(), 2u);
  EXPECT_EQ(chart.cells[0][0].line, 1u);
  EXPECT_EQ(chart.cells[1][0].line, 0u);
  EXPECT_EQ(chart.cells[0][9].line, 0u);
  EXPECT_FALSE(chart.cells[1][9].line.has_value());
}

}  // namespace
}  // namespace dccast::client
