#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_run.hpp"
#include "fake_service.hpp"
#include "json_reading.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/values/digests.hpp"

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

TEST_F(Commands, SubmitPrintsTheIdAndSendsARequestId) {
  const Result result = run({"submit", "--priority", "high", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(result.out, "job\n");
  EXPECT_EQ(service.submitted.request_id().size(), 36u);
  EXPECT_EQ(service.submitted.priority(), v1::HIGH);
}

TEST_F(Commands, TextsOfARequestAreBounded) {
  service.job.set_state(v1::CANCELLED);  // what cancel waits for
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
  EXPECT_EQ(ReadJson::parse(run({"validate", "--json", file}).out)["faults"].size(), 2u);
}

TEST_F(Commands, CurlComesAsTableCsvAndJson) {
  EXPECT_THAT(run({"curl", "job"}).out, HasSubstr("corner mm"));
  EXPECT_THAT(run({"curl", "--csv", "job"}).out,
              HasSubstr("time_s,cast_length_m,corner_curl_m,beyond_validity\n1,0.001,0.001,0\n"));
  EXPECT_EQ(ReadJson::parse(run({"curl", "--json", "job"}).out)["monitors"][0]["curl_m"].size(),
            3u);
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
  const Result away = dccast({"info"}, "unix:/tmp/dccast-no-such-socket");
  EXPECT_EQ(away.code, 4);
  EXPECT_THAT(away.err, HasSubstr("is dccastd running"));
}

TEST_F(Commands, AWordThatIsNoneIsAnsweredWithTheNearest) {
  EXPECT_THAT(run({"sumbit", file}).err, HasSubstr("did you mean 'submit'?"));
  EXPECT_THAT(run({"submit", "--prioritty", "low", file}).err,
              HasSubstr("did you mean '--priority'?"));
  EXPECT_THAT(run({"xyzzy"}).err, testing::Not(HasSubstr("did you mean")));
  // Keys of the case are no options.
  EXPECT_THAT(run({"submit", "--title", "trial", file}).err,
              HasSubstr("did you mean '--set title=...'?"));
  EXPECT_THAT(run({"query", "--casting-speed=60", file}).err,
              HasSubstr("did you mean '--set schedule.casting_speed=...'?"));
}

TEST_F(Commands, SeveralFilesAreSubmittedOrNone) {
  const Result all = run({"submit", "--label", "a", "--label", "b", file, file});
  EXPECT_EQ(all.out, "job\njob\n") << all.err;
  EXPECT_THAT(service.submitted.labels(), testing::ElementsAre("a", "b"));
  service.submitted.Clear();
  const Result none = run({"submit", file, "no-such-file.toml"});
  EXPECT_EQ(none.code, 2);
  EXPECT_EQ(none.out, "");
  EXPECT_FALSE(service.submitted.has_case_());
  EXPECT_EQ(run({"submit", "--watch", file, file}).code, 2);
  // Under one id the same file is the same job, whichever files are beside it.
  EXPECT_EQ(run({"submit", "--request-id", "x", file}).code, 0);
  const std::string once = service.submitted.request_id();
  EXPECT_EQ(run({"submit", "--request-id", "x", file, file}).code, 0);
  EXPECT_EQ(service.submitted.request_id(), once);
  EXPECT_EQ(run({"submit", "--request-id", "y", file}).code, 0);
  EXPECT_NE(service.submitted.request_id(), once);
}

TEST_F(Commands, ChangesGoWithTheCaseAndAreCheckedAsTheFileIs) {
  const Result result = run({"submit", "--set", "mesh.rows=30", "--set",
                             "schedule.water_flow.scale=0.8 until 100 mm", file});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_EQ(service.submitted.case_().mesh().rows(), 30);
  EXPECT_EQ(service.submitted.case_().schedule().water_flow_factor().value(0), 0.8);
  ASSERT_EQ(service.submitted.changes_size(), 2);
  EXPECT_EQ(service.submitted.changes(1).value(), "0.8 until 100 mm");
  const Result fault = run({"validate", "--set", "mesh.rows=many", file});
  EXPECT_EQ(fault.code, 2);
  EXPECT_THAT(fault.out, HasSubstr("--set mesh.rows, column 11: mesh.rows = \"many\""));
  EXPECT_EQ(run({"validate", "--set", "mesh.rows", file}).code, 2);
}

TEST_F(Commands, TheBeginningOfAnIdIsEnoughWhereItIsTheOnlyOne) {
  for (const char* const id :
       {"0f2b9a4e-0000-4000-8000-000000000000", "0f2b1111-0000-4000-8000-000000000000"})
    service.listed_jobs.emplace_back(service.job).set_id(id);
  service.job.set_id("0f2b9a4e-0000-4000-8000-000000000000");
  EXPECT_EQ(run({"show", "0f2b9"}).code, 0);
  const Result two = run({"show", "0f2b"});
  EXPECT_EQ(two.code, 2);
  EXPECT_THAT(two.err, HasSubstr("more than one job:\n  0f2b9a4e-"));
  const Result none = run({"show", "aa"});
  EXPECT_EQ(none.code, 5);
  EXPECT_THAT(none.err, HasSubstr("begins with 'aa'"));
  EXPECT_THAT(run({"list"}).out, HasSubstr("0f2b9a4e  succeeded"));
}

TEST_F(Commands, TheLastJobIsTheNewestOfThisUser) {
  v1::Job run_of_a_study = service.job;
  run_of_a_study.set_id("11111111-1111-4111-8111-111111111111");
  run_of_a_study.set_study("22222222-2222-4222-8222-222222222222");
  service.listed_jobs = {run_of_a_study};
  EXPECT_EQ(run({"show", "last"}).code, 5);
  service.listed_jobs.push_back(service.job);
  const Result shown = run({"show", "last"});
  EXPECT_EQ(shown.code, 0);
  EXPECT_THAT(shown.out, HasSubstr(service.job.id()));
  EXPECT_FALSE(service.listed.owner().empty());
}

TEST_F(Commands, AListHasTheColumnsThatSaySomething) {
  EXPECT_THAT(run({"list"}).out, testing::Not(HasSubstr("LABELS")));
  service.job.add_labels("trial-7");
  service.job.add_findings()->set_severity(v1::Finding::DANGER);
  *service.job.mutable_last_step() = service.events[4].step();
  const Result result = run({"list", "--label", "trial-7"});
  EXPECT_THAT(service.listed.labels(), testing::ElementsAre("trial-7"));
  EXPECT_THAT(result.out, HasSubstr("CURL mm"));
  EXPECT_THAT(result.out, HasSubstr("3.00"));
  EXPECT_THAT(result.out, HasSubstr("1 danger"));
  EXPECT_THAT(result.out, HasSubstr("trial-7"));
  EXPECT_THAT(run({"list", "--columns", "job,owner"}).out, testing::StartsWith("JOB  OWNER\n"));
  EXPECT_EQ(run({"list", "--ids"}).out, "job\n");
}

TEST_F(Commands, WaitSaysHowEachJobEnded) {
  service.job.mutable_end_time()->set_seconds(1);
  const Result done = run({"wait", "job", "job"});
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.out, "job succeeded\njob succeeded\n");
  service.job.set_state(v1::FAILED);
  EXPECT_EQ(run({"wait", "job"}).code, 3);
}

TEST_F(Commands, DeleteWaitsForAJobThatIsBeingCancelled) {
  service.deletions_aborted = 2;
  EXPECT_EQ(run({"delete", "--cancel", "job"}).code, 0);
  EXPECT_EQ(service.cancelled.id(), "job");
  EXPECT_THAT(service.deleted, testing::ElementsAre("job"));
}

TEST_F(Commands, NoFileIsOverwrittenUnasked) {
  const Result refused = run({"report", "job", "-o", file});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--force"));
  EXPECT_EQ(run({"fetch", "job", "-o", file}).code, 2);
  EXPECT_EQ(run({"new", shipped::case_templates().back().name, "-o", file}).code, 2);
  EXPECT_EQ(run({"report", "--force", "job", "-o", file}).code, 0);
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
  const ReadJson rows = ReadJson::parse(run({"schema", "--json"}).out);
  EXPECT_GT(rows.size(), 90u);
  const std::string speed = run({"schema", "casting_speed"}).out;
  EXPECT_THAT(speed, HasSubstr("0 to 0.1 m/s"));
  EXPECT_THAT(speed, HasSubstr("of at most 10000 points"));
  EXPECT_THAT(run({"schema", "title"}).out, HasSubstr("at most 200 bytes"));
  EXPECT_THAT(run({"schema", "monitor"}).out, HasSubstr("at most 1000 entries"));
}

}  // namespace
}  // namespace dccast::client
