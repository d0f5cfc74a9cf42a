#include "client/text/findings.hpp"

#include <sstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/pages.hpp"
#include "client/model/json.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/study_text.hpp"
#include "client_run.hpp"
#include "fake_service.hpp"
#include "json_reading.hpp"

namespace dccast::client {
namespace {

using testing::HasSubstr;
using testing::Not;

v1::Finding slide() {
  v1::Finding loss;
  loss.set_kind(v1::Finding::MOTION_TOO_LARGE);
  loss.set_message("the butt has slid 63.1 mm over the bottom block");
  loss.set_time_s(3.0);
  loss.add_place_m(0.12);
  loss.add_place_m(0.003);
  loss.set_value(0.0631);
  loss.set_limit(0.02);
  loss.set_unit("m");
  return loss;
}

constexpr const char* sentence =
    "beyond validity from 3.00 s on: the butt has slid 63.1 mm over the bottom block";

/// Five steps, the last three after the loss.
std::vector<v1::JobEvent> events_with_a_loss() {
  auto events = run_of(5);
  for (v1::JobEvent& event : events)
    if (event.has_step() && event.step().step() >= 3)
      event.mutable_step()->set_beyond_validity(true);
  v1::JobEvent lost;
  *lost.mutable_validity_lost() = slide();
  events.insert(events.begin() + 4, lost);
  for (std::size_t i = 0; i < events.size(); ++i)
    events[i].set_sequence(static_cast<std::int64_t>(i) + 1);
  return events;
}

struct Validity : testing::Test {
  FakeService service;
  void SetUp() override {
    service.job.set_id("job");
    service.job.set_state(v1::SUCCEEDED);
    *service.job.mutable_validity_loss() = slide();
    service.events = events_with_a_loss();
    for (const v1::JobEvent& event : service.events)
      if (event.has_step())
        *service.job.mutable_last_step() = *service.result.add_steps() = event.step();
  }
  Result run(std::vector<std::string> arguments) {
    return dccast(std::move(arguments), service.address());
  }
};

TEST(ValidityText, SaysWhenWhyByHowMuchAndWhere) {
  EXPECT_EQ(validity_text(slide()), sentence);
  v1::Finding bare;
  bare.set_kind(v1::Finding::MOTION_TOO_LARGE);
  bare.set_time_s(166.2);
  bare.set_value(0.24);
  bare.set_limit(0.15);
  bare.set_unit("1");
  EXPECT_EQ(validity_text(bare),
            "beyond validity from 166.20 s on: motion too large (0.24, limit 0.15)");
}

TEST_F(Validity, ShowAndListSayIt) {
  const Result shown = run({"show", "job"});
  EXPECT_THAT(shown.out, HasSubstr(std::string("validity      ") + sentence));
  EXPECT_THAT(shown.out, HasSubstr("t 5.00 s  beyond validity"));
  EXPECT_THAT(shown.out, Not(HasSubstr("curls at the end")));
  const std::string listed = run({"list"}).out;
  EXPECT_THAT(listed, HasSubstr("succeeded, beyond validity"));
  EXPECT_THAT(listed, Not(HasSubstr("5.00"))) << "no curl as of a good run";
  EXPECT_EQ(ReadJson::parse(run({"list", "--json"}).out)[0]["validity_loss"]["kind"],
            "MOTION_TOO_LARGE");
}

TEST_F(Validity, ARunThatFailedIsListedWithoutACurl) {
  service.job.clear_validity_loss();
  EXPECT_THAT(run({"list"}).out, HasSubstr("5.00"));
  service.job.set_state(v1::FAILED);
  EXPECT_THAT(run({"list"}).out, Not(HasSubstr("5.00")));
}

TEST_F(Validity, WatchMarksEveryLineAfterIt) {
  const Result watched = run({"watch", "job"});
  EXPECT_THAT(watched.out, HasSubstr(std::string("warning: ") + sentence));
  EXPECT_THAT(watched.out, HasSubstr("step 2  t 2.00 s  cast"));
  EXPECT_THAT(watched.out, HasSubstr("step 3  t 3.00 s  beyond validity  cast"));
  EXPECT_THAT(watched.out, HasSubstr("cast length 5.0 mm, beyond validity\n"));

  std::istringstream lines(run({"watch", "--json", "job"}).out);
  int marked = 0, losses = 0;
  for (std::string text; std::getline(lines, text);) {
    const ReadJson line = ReadJson::parse(text);
    if (line["event"] == "step") marked += line["beyond_validity"] == true;
    if (line["event"] == "validity_lost") losses += line["validity_loss"]["limit"] == 0.02;
  }
  EXPECT_EQ(marked, 3);
  EXPECT_EQ(losses, 1);
}

TEST_F(Validity, CurlMarksItInTableCsvAndJson) {
  const Result table = run({"curl", "job"});
  EXPECT_THAT(table.out, HasSubstr("validity\n"));
  EXPECT_THAT(table.out, HasSubstr("2.000\n"));
  EXPECT_THAT(table.out, HasSubstr("3.000  beyond validity\n"));
  EXPECT_THAT(table.err, HasSubstr(sentence));
  const std::string csv = run({"curl", "--csv", "job"}).out;
  EXPECT_THAT(csv, HasSubstr("corner_curl_m,beyond_validity\n"));
  EXPECT_THAT(csv, HasSubstr("\n2,0.002,0.002,0\n3,0.003,0.003,1\n"));
  const ReadJson json = ReadJson::parse(run({"curl", "--json", "job"}).out);
  EXPECT_EQ(json["beyond_validity"], (ReadJson{false, false, true, true, true}));
  EXPECT_EQ(json["validity_loss"]["time_s"], 3.0);
}

TEST_F(Validity, TheReportShadesTheRegionAndSaysASentence) {
  const std::string page = run({"report", "job", "-o", "-"}).out;
  EXPECT_THAT(page, HasSubstr(std::string("<p class='invalid'>This run is ") + sentence));
  EXPECT_THAT(page, HasSubstr("\"beyond_x\":3.0"));
  EXPECT_THAT(page, HasSubstr("Shaded red: beyond validity."));
  EXPECT_THAT(page, HasSubstr("Figures of the last step are beyond validity."));
  EXPECT_THAT(page, HasSubstr("last step, beyond validity"));
}

TEST_F(Validity, ARunThatIsValidHasNoMarkAnywhere) {
  service.job.clear_validity_loss();
  service.events = run_of(5);
  service.result.clear_steps();
  for (const v1::JobEvent& event : service.events)
    if (event.has_step())
      *service.job.mutable_last_step() = *service.result.add_steps() = event.step();
  for (const char* const command : {"show", "watch", "curl", "list"}) {
    const bool of_job = std::string(command) != "list";
    const Result result =
        run(of_job ? std::vector<std::string>{command, "job"} : std::vector<std::string>{command});
    EXPECT_THAT(result.out + result.err, Not(HasSubstr("beyond"))) << command;
  }
  const std::string page = run({"report", "job", "-o", "-"}).out;

  EXPECT_THAT(page, Not(HasSubstr("eyond validity")));
  EXPECT_THAT(page, Not(HasSubstr("\"beyond\"")));
}

TEST(FailureText, HasKindPlaceAndFurtherCauses) {
  v1::Finding failure;
  failure.set_kind(v1::Finding::SHELL_MELTED_THROUGH);
  failure.set_message("no solid path from the symmetry plane to the side");
  failure.set_time_s(166.0);
  failure.set_time_step_s(0.5);
  failure.add_place_m(0.12);
  failure.add_place_m(0.0);
  failure.add_further()->set_message("the results could not be published");
  failure.mutable_further(0)->set_kind(v1::Finding::STORAGE);

  EXPECT_EQ(failure_text(failure),
            "shell melted through: no solid path from the symmetry plane to the side\n"
            "at 166.000 s with a step of 0.5 s, x 120.0 mm, y 0.0 mm\n"
            "then: storage: the results could not be published");
  EXPECT_EQ(ReadJson::parse(to_json(failure).dump())["further"][0]["message"],
            "the results could not be published");
  for (int kind = v1::Finding::Kind_MIN; kind <= v1::Finding::Kind_MAX; ++kind)
    EXPECT_THAT(failure_kind_text(static_cast<v1::Finding::Kind>(kind)), Not(HasSubstr("_")));
}

TEST_F(Validity, WhatIsHeldSaysWhy) {
  service.job.clear_validity_loss();
  service.job.set_state(v1::QUEUED);
  service.job.set_queue_position(3);
  service.job.set_held("no space left on /var/lib/dccast");
  service.info.set_storage_fault("no space left on /var/lib/dccast");
  service.info.set_quarantined(2);
  service.info.set_maximum_nodes(400000);
  EXPECT_THAT(run({"show", "job"}).out, HasSubstr("held          no space left on"));

  const Result listed = run({"list"});
  EXPECT_THAT(listed.out, HasSubstr("queued #3, held"));
  EXPECT_EQ(listed.err, "held: no space left on /var/lib/dccast\n");
  EXPECT_THAT(run({"watch", "job"}).err, HasSubstr("held: no space left on /var/lib/dccast\n"));

  const Result info = run({"info"});
  EXPECT_THAT(info.out, HasSubstr("held     no space left on"));
  EXPECT_THAT(info.out, HasSubstr("2 folders without a job"));
  EXPECT_THAT(info.out, HasSubstr("ceilings 400000 nodes"));
}

}  // namespace
}  // namespace dccast::client
