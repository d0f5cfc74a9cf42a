#include "server/worker/run.hpp"

#include <gtest/gtest.h>

#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::worker {
namespace {

class JobRunTest : public testing::Test {
protected:
  JobRunTest() {
    order_.set_directory(folder_.path() / "jobs" / "job");
    order_.set_job_id("a-job");
    order_.set_attempt(1);
    std::filesystem::create_directories(order_.directory());
    claim_.emplace(order_.directory(), jobs::WorkerClaim{"a-job", 1}, std::chrono::seconds(1));
  }
  static v1::JobEvent step(std::int64_t number) {
    v1::JobEvent event;
    event.mutable_step()->set_step(number);
    return event;
  }
  static v1::JobEvent finding(const std::string& code) {
    v1::JobEvent event;
    event.mutable_finding()->set_code(code);
    return event;
  }
  std::filesystem::path log() const {
    return std::filesystem::path(order_.directory()) / "events.log";
  }

  TemporaryFolder folder_;
  v1::SolveCase order_;
  std::optional<jobs::FolderClaim> claim_;
};

TEST_F(JobRunTest, WhatItSendsStandsInTheLogAndSoDoesItsEnd) {
  jobs::EventLog reader(log());
  JobRun run(order_, *claim_);
  run.send(step(1));
  EXPECT_TRUE(reader.refresh());
  EXPECT_EQ(reader.content().reached_step, 1);
  v1::RunEnd end;
  end.set_outcome(v1::RunEnd::SUCCEEDED);
  end.set_attempt(1);
  run.end(end);
  EXPECT_TRUE(reader.refresh());
  EXPECT_EQ(reader.content().run_end->outcome(), v1::RunEnd::SUCCEEDED);
}

// A run that goes on from a checkpoint sends again what it has found.
TEST_F(JobRunTest, AFindingStandsInTheLogOnce) {
  JobRun(order_, *claim_).send(finding("bleed_out"));
  JobRun again(order_, *claim_);
  again.send(finding("bleed_out"));
  again.send(finding("another"));
  EXPECT_EQ(jobs::EventLog(log()).last_sequence(), 2);
}

TEST_F(JobRunTest, HasTheStepsOfEarlierAttempts) {
  {
    JobRun run(order_, *claim_);
    for (const std::int64_t number : {1, 2, 3, 4}) run.send(step(number));
    v1::JobEvent resumed;
    resumed.mutable_resumed()->set_step(2);
    run.send(resumed);
    run.send(step(3));
  }
  const JobRun again(order_, *claim_);
  std::vector<std::int64_t> numbers;
  for (const v1::StepReport& each : again.steps(10)) numbers.push_back(each.step());

  EXPECT_EQ(numbers, (std::vector<std::int64_t>{1, 2, 3}));
  EXPECT_EQ(again.steps(2).size(), 2u);
}

TEST_F(JobRunTest, FollowsARequestInItsFolder) {
  JobRun run(order_, *claim_);
  EXPECT_EQ(run.order(), casting::Order::go_on);
  jobs::write_request(order_.directory(), {jobs::RequestedAction::pause, ""});
  EXPECT_EQ(run.order(), casting::Order::stop_at_checkpoint);
  jobs::write_request(order_.directory(), {jobs::RequestedAction::cancel, "wrong alloy"});
  EXPECT_EQ(run.order(), casting::Order::cancel);
}

TEST_F(JobRunTest, GivesSignsOfLife) {
  order_.set_heartbeat_interval_s(0.01);
  const JobRun run(order_, *claim_);
  const auto first = jobs::signs_in(order_.directory()).claimed_ns;
  EXPECT_TRUE(eventually([&] { return jobs::signs_in(order_.directory()).claimed_ns != first; }));
}

TEST_F(JobRunTest, StopsAtACheckpointWhenNoDaemonComes) {
  order_.set_heartbeat_interval_s(0.01);
  order_.set_daemon_patience_s(0.3);
  const auto alive = folder_.path() / "lock";
  const JobRun run(order_, *claim_);
  for (int i = 0; i < 12; ++i) {  // twice as long as it waits
    storage::write_file(alive, std::string(1, static_cast<char>('a' + i)));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));  // the pace of a daemon's signs
  }
  EXPECT_EQ(run.order(), casting::Order::go_on);

  EXPECT_TRUE(eventually([&] { return run.order() != casting::Order::go_on; }));
  EXPECT_EQ(run.order(), casting::Order::stop_at_checkpoint);
}

}  // namespace
}  // namespace dccast::worker
