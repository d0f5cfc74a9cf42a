#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/message_json.hpp"
#include "client_run.hpp"
#include "fake_service.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/values/sha256.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;

struct Commands : testing::Test {
  FakeService service;
  std::string file = (std::filesystem::path(testing::TempDir()) /
                      ("dccast_commands_" + std::to_string(::getpid()) + ".toml"))
                         .string();

  void SetUp() override {
    service.job.set_id("job");
    service.job.set_state(v1::SUCCEEDED);
    service.events = run_of(3);
    for (const v1::JobEvent& event : service.events)
      if (event.has_step()) *service.result.add_steps() = event.step();
    std::ofstream(file) << shipped::case_templates().back().text;
  }
  void TearDown() override { std::filesystem::remove(file); }
  Result run(std::vector<std::string> arguments) {
    return dccast(std::move(arguments), service.address());
  }
};

TEST_F(Commands, EveryCommandHasAnExample) {
  for (const char* const name :
       {"new", "validate", "submit", "watch", "list", "show", "curl", "fetch", "report",
        "convergence", "cancel", "pause", "resume", "delete", "schema", "alloys", "info"}) {
    const Result result = run({name, "--help"});
    EXPECT_EQ(result.code, 0);
    EXPECT_THAT(result.out, HasSubstr("Example:\n  dccast " + std::string(name)));
    EXPECT_THAT(result.out, HasSubstr("--json")) << name;
  }
}

TEST_F(Commands, SubmitPrintsTheIdAndSendsARequestId) {
  const Result result = run({"submit", "--priority", "high", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "job\n");
  EXPECT_EQ(service.submitted.request_id().size(), 36u);
  EXPECT_EQ(service.submitted.priority(), v1::HIGH);
}

TEST_F(Commands, TextsOfARequestAreBounded) {
  const std::string longer(201, 'x');
  EXPECT_EQ(run({"cancel", "job", "--reason", longer.substr(1)}).code, 0);
  EXPECT_EQ(service.cancelled.reason().size(), 200u);
  const Result refused = run({"cancel", "job", "--reason", longer});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("the reason has 201 bytes; at most 200 are permitted"));
  EXPECT_EQ(run({"submit", "--request-id", longer, file}).code, 2);
}

TEST_F(Commands, SubmitAndWatchEndsAsTheJobDoes) {
  const Result done = run({"submit", "--watch", file});
  EXPECT_EQ(done.code, 0);
  EXPECT_THAT(done.out, HasSubstr("corner     3.000"));
  EXPECT_THAT(done.err, HasSubstr("step 3"));
  service.events = run_of(2, v1::FAILED);
  const Result failed = run({"watch", "job"});
  EXPECT_EQ(failed.code, 3);
  EXPECT_THAT(failed.err, HasSubstr("the step fell below its minimum"));
}

TEST_F(Commands, AnInvalidCaseShowsTheFaultsOfBothSidesAtTheirPlaces) {
  std::ofstream(file) << "[section]\nhalf_width = 3\ninitial_depth = \"10 cm\"\n[time]\nend = \"1 "
                         "s\"\n[[monitor]]\nname = "
                         "\"a\"\nx = \"5 m\"\ny = \"0 m\"\n";
  v1::Fault& outside = *service.verdict.add_faults();
  outside.set_field("monitor[0].x");
  outside.set_message("outside the slab");
  const Result result = run({"submit", file});
  EXPECT_EQ(result.code, 2);
  EXPECT_THAT(result.err, HasSubstr(file + ":2:1: section.half_width = 3: the unit is missing"));
  EXPECT_THAT(result.err, HasSubstr(file + ":8:1: monitor[0].x: outside the slab"));
  EXPECT_EQ(Json::parse(run({"validate", "--json", file}).out)["faults"].size(), 2u);
}

TEST_F(Commands, CurlComesAsTableCsvAndJson) {
  EXPECT_THAT(run({"curl", "job"}).out, HasSubstr("corner mm"));
  EXPECT_THAT(run({"curl", "--csv", "job"}).out,
              HasSubstr("time_s,cast_length_m,corner_curl_m,beyond_validity\n1,0.001,0.001,0\n"));
  EXPECT_EQ(Json::parse(run({"curl", "--json", "job"}).out)["monitors"][0]["curl_m"].size(), 3u);
  EXPECT_EQ(run({"curl", "--json", "--csv", "job"}).code, 2);
}

TEST_F(Commands, AFetchedSidecarRefersToItsNeighbourByNameAlone) {
  service.artifact = "<DataItem>results.h5:/a</DataItem><DataItem>results.h5:/b</DataItem>";
  std::ofstream(file) << service.artifact;  // the service has one artifact for both
  service.artifact_sha256 = values::sha256_of_file(file);
  const auto folder = std::filesystem::path(file).replace_extension();
  std::filesystem::create_directory(folder);
  EXPECT_EQ(run({"fetch", "job", "-o", (folder / "hot & cold.h5").string()}).code, 0);
  std::ostringstream sidecar;
  sidecar << std::ifstream(folder / "hot & cold.xdmf").rdbuf();
  EXPECT_EQ(sidecar.str(),
            "<DataItem>hot &amp; cold.h5:/a</DataItem>"
            "<DataItem>hot &amp; cold.h5:/b</DataItem>");
  std::filesystem::remove_all(folder);
}

TEST_F(Commands, ExitCodesTellWhatWentWrong) {
  EXPECT_EQ(run({"show", "absent"}).code, 5);
  EXPECT_EQ(run({"no-such-command"}).code, 2);
  EXPECT_EQ(run({}).code, 2);
  EXPECT_EQ(run({"new", "no-such-case"}).code, 5);
  const Result away = dccast({"info"}, "127.0.0.1:1");
  EXPECT_EQ(away.code, 4);
  EXPECT_THAT(away.err, HasSubstr("is dccastd running"));
}

TEST_F(Commands, JobsOfAStudyAreListedAndShownAsSuch) {
  EXPECT_THAT(run({"show", "job"}).out, testing::Not(HasSubstr("study")));
  service.job.set_study("0f2b9a4e-0000-4000-8000-000000000000");
  EXPECT_THAT(run({"show", "job"}).out, HasSubstr("study         0f2b9a4e-"));
  EXPECT_EQ(run({"list", "--study", service.job.study()}).code, 0);
  EXPECT_EQ(service.listed.study(), service.job.study());
}

TEST_F(Commands, AReportWithoutAFrameIsStillAReport) {
  const Result result = run({"report", "job", "-o", "-"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("No stored frame"));
}

TEST_F(Commands, TheSchemaListsEveryKey) {
  const Json rows = Json::parse(run({"schema", "--json"}).out);
  EXPECT_GT(rows.size(), 90u);
  const std::string speed = run({"schema", "casting_speed"}).out;
  EXPECT_THAT(speed, HasSubstr("0 to 0.1 m/s"));
  EXPECT_THAT(speed, HasSubstr("of at most 10000 points"));
  EXPECT_THAT(run({"schema", "title"}).out, HasSubstr("at most 200 bytes"));
  EXPECT_THAT(run({"schema", "monitor"}).out, HasSubstr("at most 1000 entries"));
}

}  // namespace
}  // namespace dccast::client
