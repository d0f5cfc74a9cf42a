// Slurm as four small programs in PATH: what squeue shows stands in a file, what is asked of the
// others goes into one. The real Slurm is in tests/service/slurm_test.py.
#include "server/jobs/executors/slurm_executor.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>

#include <condition_variable>
#include <fstream>
#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/logs/event_log.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::Not;
using namespace std::chrono_literals;

/// For jobs that go first.
class NearExecutor : public Executor {
public:
  void set_calls(Calls) override {}
  int capacity() const override { return 1; }
  void start(const WorkerLaunch& launch) override { started += launch.job_id; }
  void stop(const std::string&, int) override {}
  void kill(const std::string&, int) override {}
  Adoption adopt(const WorkerLaunch&, bool) override { return Adoption::gone; }
  std::string started;
};

class SlurmExecutorTest : public testing::Test {
protected:
  SlurmExecutorTest() {
    fs::create_directory(folder_ / "bin");
    program("squeue",
            "printf . >> looks; test -e queue || { echo 'Unable to contact slurm controller' >&2; "
            "exit 1; }; "
            "cat queue");
    program("sbatch",
            "echo sbatch \"$@\" >> asked; cat >> asked; "
            "test ! -e refusal || { cat refusal >&2; exit 1; }");
    program("scancel", "echo scancel \"$@\" >> asked");
    ::setenv("PATH", ((folder_ / "bin").string() + ":" + path_).c_str(), 1);
    fs::create_directory(job_);
    shows("");
  }
  ~SlurmExecutorTest() override { ::setenv("PATH", path_.c_str(), 1); }

  void program(const char* name, const std::string& body) {
    const auto file = folder_ / "bin" / name;
    storage::write_file(file, "#!/bin/sh\ncd " + folder_.path().string() + "\n" + body + "\n");
    fs::permissions(file, fs::perms::owner_all);
  }
  /// Later output of squeue.
  void shows(const std::string& lines) { storage::replace_file(folder_ / "queue", lines); }
  void shows_start(const std::string& state, const std::string& reason = "None", int attempt = 1) {
    shows("other|RUNNING|None|0|\ndccast-foreign.1|RUNNING|None|0|\ndccast-a-job." +
          std::to_string(attempt) + "|" + state + "|" + reason + "|0|\n");
  }
  std::string asked() const {
    return fs::exists(folder_ / "asked") ? storage::read_file(folder_ / "asked") : "";
  }
  /// How often squeue was run.
  std::size_t looks() const {
    return fs::exists(folder_ / "looks") ? storage::read_file(folder_ / "looks").size() : 0;
  }
  WorkerLaunch launch(int attempt = 1) const {
    WorkerLaunch launch{.job_id = "a-job", .attempt = attempt, .folder = job_};
    launch.order.set_job_id("a-job");
    launch.order.set_attempt(attempt);
    launch.order.set_directory(job_);
    return launch;
  }
  void begin(int attempt = 1) {
    if (!executor_) executor_.emplace(near_, options_);
    executor_->end_adoption();
    executor_->set_calls(
        {.not_started = [this](auto&&, int,
                               const std::string& why) { report("not started: " + why); },
         .ended =
             [this](auto&&, int number, const WorkerExit& exit) {
               report(std::to_string(number) + " ended: " + exit.how +
                      (exit.of_machine ? ", of the machine" : "") +
                      (exit.cancelled ? ", cancelled" : ""));
             },
         .waits =
             [this](auto&&, int, const std::string& why) {
               const std::lock_guard lock(mutex_);
               waits_ = why;
               changed_.notify_all();
             },
         .stopped = [](auto&&...) {}});
    executor_->start(launch(attempt));
  }
  void report(const std::string& text) {
    const std::lock_guard lock(mutex_);
    reported_ += text;
    changed_.notify_all();
  }
  std::string reported(std::chrono::milliseconds longest = 10s) {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, longest, [this] { return !reported_.empty(); });
    return reported_;
  }
  bool waits_for(const std::string& why) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, 10s, [&] { return waits_.find(why) != std::string::npos; });
  }
  bool is_asked(const std::string& words) {
    return eventually([&] { return asked().find(words) != std::string::npos; });
  }
  void end_run(int attempt = 1) {
    EventLog log(job_ / "events.log");
    v1::JobEvent event;
    event.mutable_run_ended()->set_outcome(v1::RunEnd::STOPPED);
    event.mutable_run_ended()->set_attempt(attempt);
    log.append(event);
  }

  const std::string path_ = ::getenv("PATH");
  TemporaryFolder folder_;
  const fs::path job_ = folder_ / "a-job";
  NearExecutor near_;
  SlurmOptions options_{.jobs_directory = folder_.path(),
                        .worker_program = "/opt/the worker",
                        .options = {"--partition=long"},
                        .time_limit = 90s,
                        .checkpoint_before = 60s,
                        .memory_bytes = 3e9,
                        .interval = 20ms,
                        .unsure = 100ms,
                        .silence = 200ms,
                        .visibility = 60s};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::string reported_, waits_;
  std::optional<SlurmExecutor> executor_;
};

TEST_F(SlurmExecutorTest, HandsOnNameLimitsAndTheFolder) {
  begin();
  ASSERT_TRUE(is_asked("exec '/opt/the worker' --run '" + job_.string() + "' 1"));
  for (const char* word :
       {"--job-name=dccast-a-job.1", "--comment=dccast job a-job, attempt 1", "--time=2",
        "--mem=2862M", "--cpus-per-task=1", "--requeue", "--signal=B:TERM@60", "--partition=long"})
    EXPECT_THAT(asked(), HasSubstr(word));
  shows_start("PENDING", "Resources");
  EXPECT_TRUE(waits_for("PENDING, Resources"));
  EXPECT_EQ(read_order(job_)->attempt(), 1);
}

// A network file system shows the end of a run long after Slurm has seen that of the worker.
TEST_F(SlurmExecutorTest, WaitsUntilTheEndOfTheRunCanBeSeen) {
  begin();
  shows_start("COMPLETED");
  EXPECT_EQ(reported(500ms), "") << "that its log is not there yet is no end";
  end_run();
  EXPECT_EQ(reported(), "1 ended: exit code 0");
}

TEST_F(SlurmExecutorTest, TheEndOfAnEarlierAttemptIsNone) {
  end_run(1);
  begin(2);
  shows_start("COMPLETED", "None", 2);
  EXPECT_EQ(reported(500ms), "");
}

TEST_F(SlurmExecutorTest, AJobThatSlurmHasLostIsLeftAloneWhileItsFolderShowsLife) {
  begin();
  ASSERT_TRUE(is_asked("sbatch"));
  for (int i = 0; i < 30; ++i) {
    std::ofstream(job_ / "events.log", std::ios::app) << "grows";
    EXPECT_EQ(reported(20ms), "");
  }
  EXPECT_EQ(reported(), "1 ended: Slurm has lost it, of the machine");
}

TEST_F(SlurmExecutorTest, AfterThreeLossesWithoutASignOfLifeItSaysWhatIsWrong) {
  for (int attempt = 1; attempt <= 3; ++attempt) {
    {
      const std::lock_guard lock(mutex_);
      reported_.clear();
    }
    EXPECT_TRUE(!executor_ || executor_->lacks().empty());
    begin(attempt);
    const std::string loss = reported();
    EXPECT_THAT(loss, HasSubstr(attempt < 3 ? "Slurm has lost it"
                                            : "not started: Slurm took 3 jobs in a row"));
  }
  EXPECT_THAT(executor_->lacks(), HasSubstr("slurm.options"));
}

TEST_F(SlurmExecutorTest, AJobThatAnAdministratorCancelsIsCancelled) {
  begin();
  ASSERT_TRUE(is_asked("sbatch"));
  shows_start("CANCELLED");
  EXPECT_EQ(reported(), "1 ended: CANCELLED in Slurm, cancelled");
}

TEST_F(SlurmExecutorTest, AControllerThatGivesNoAnswerEndsNothing) {
  begin();
  ASSERT_TRUE(is_asked("sbatch"));
  fs::remove(folder_ / "queue");
  EXPECT_TRUE(waits_for("Slurm gives no answer"));
  EXPECT_EQ(reported(600ms), "");
  end_run();
  EXPECT_EQ(reported(), "1 ended: exit code 0") << "the folder needs no controller";
}

TEST_F(SlurmExecutorTest, ARefusalIsOfTheRequestAndATimeoutOfNone) {
  storage::write_file(folder_ / "refusal", "sbatch: error: invalid partition specified\n");
  begin();
  EXPECT_EQ(reported(), "not started: sbatch: error: invalid partition specified");
  reported_.clear();
  storage::write_file(folder_ / "refusal", "sbatch: error: Socket timed out on send/recv\n");
  begin(2);
  ASSERT_TRUE(is_asked("dccast-a-job.2"));
  shows_start("RUNNING", "None", 2);  // it had arrived
  EXPECT_EQ(reported(500ms), "");
}

/// Filters and plug-ins of a site write what they like.
TEST_F(SlurmExecutorTest, WhatSlurmSaysIsRepeatedInOnePrintableLine) {
  storage::write_file(folder_ / "refusal",
                      "sbatch: \x1b[2Jerror\x07 \xff" + std::string(5000, 'x') + "\nmore\n");
  begin();
  const std::string said = reported();
  EXPECT_THAT(said, HasSubstr("not started: sbatch: \\u{1B}[2Jerror\\u{7} \\x{FF}xxx"));
  EXPECT_THAT(said, Not(HasSubstr("more")));
  EXPECT_LT(said.size(), 400u);
}

TEST_F(SlurmExecutorTest, NothingIsSubmittedBesideAnEarlierStart) {
  shows_start("RUNNING", "None", 1);
  begin(2);
  ASSERT_TRUE(is_asked("scancel --name=dccast-a-job.1"));
  ASSERT_TRUE(eventually([&, before = looks()] { return looks() >= before + 3; }));
  EXPECT_THAT(asked(), Not(HasSubstr("sbatch")));
  shows_start("CANCELLED", "None", 1);
  EXPECT_TRUE(is_asked("--job-name=dccast-a-job.2"));
}

TEST_F(SlurmExecutorTest, StopsByASignalAndCancelsWhatWaits) {
  begin();
  ASSERT_TRUE(is_asked("sbatch"));
  shows_start("RUNNING");
  executor_->stop("a-job", 1);
  EXPECT_TRUE(is_asked("scancel --batch --signal=TERM --name=dccast-a-job.1"));
  shows_start("PENDING", "Priority");
  EXPECT_TRUE(is_asked("scancel --name=dccast-a-job.1"));
}

// After kill -9 of slurmctld a job may be held although its worker runs.
TEST_F(SlurmExecutorTest, AJobHeldAfterAFailedLaunchIsCancelledOnceItsFolderIsSilent) {
  options_.silence = 1s;  // much longer than a busy machine keeps this thread from writing
  begin();
  shows_start("PENDING", "launch_failed_requeued_held");
  for (int i = 0; i < 75; ++i) {
    std::ofstream(job_ / "events.log", std::ios::app) << "grows";
    std::this_thread::sleep_for(20ms);  // longer in all than a folder may be silent
  }
  EXPECT_THAT(asked(), Not(HasSubstr("scancel")));
  EXPECT_TRUE(is_asked("scancel --name=dccast-a-job.1"));
  shows_start("CANCELLED");
  EXPECT_THAT(reported(), HasSubstr("of the machine"));
}

// A crash of slurmctld takes back what it knew of the last seconds.
TEST_F(SlurmExecutorTest, WhatHasEndedAndRunsAgainInSlurmIsCancelled) {
  begin();
  shows_start("RUNNING");
  end_run();
  EXPECT_EQ(reported(), "1 ended: exit code 0") << "of a job that Slurm takes for running";
  executor_->start(launch(2));
  ASSERT_TRUE(is_asked("scancel --name=dccast-a-job.1"));
  EXPECT_THAT(asked(), Not(HasSubstr("dccast-foreign")));
}

// An attempt begins once: the next one says in the log where it goes on.
TEST_F(SlurmExecutorTest, AnAttemptThatSlurmWouldStartAgainIsFollowedByTheNext) {
  begin();
  ASSERT_TRUE(is_asked("sbatch"));
  announce_rank(job_, {.attempt = 1});
  shows_start("PENDING", "BeginTime");
  EXPECT_TRUE(is_asked("scancel --name=dccast-a-job.1"));
  shows_start("CANCELLED");
  EXPECT_THAT(reported(), HasSubstr("of the machine"));
}

TEST_F(SlurmExecutorTest, AStartThatFoundItsAttemptBegunIsNoLossOfTheJob) {
  begin();
  shows("dccast-a-job.1|FAILED|NonZeroExitCode|19200|\n");
  EXPECT_THAT(reported(), HasSubstr("of the machine"));
}

TEST_F(SlurmExecutorTest, SaysHowAWorkerHasEnded) {
  begin();
  shows("dccast-a-job.1|FAILED|NonZeroExitCode|18944|\n");
  EXPECT_EQ(reported(), "1 ended: FAILED in Slurm, exit code 74");
}

TEST_F(SlurmExecutorTest, FindsAgainWhatItHasStartedAndEndsWhatIsNotWanted) {
  executor_.emplace(near_, options_);
  executor_->set_calls({});
  EXPECT_EQ(executor_->adopt(launch(), true), Adoption::gone) << "of the local executor";
  write_order(launch().order);
  shows_start("RUNNING");
  EXPECT_EQ(executor_->adopt(launch(), true), Adoption::found);
  EXPECT_EQ(executor_->adopt(launch(2), false), Adoption::gone);
  end_run();
  EXPECT_EQ(executor_->adopt(launch(), true), Adoption::gone) << "its run has ended";
}

TEST_F(SlurmExecutorTest, WhatGoesFirstDoesNotQueue) {
  executor_.emplace(near_, options_);
  auto first = launch();
  first.order.set_goes_first(true);
  executor_->start(first);
  EXPECT_EQ(near_.started, "a-job");
}

// If locks do not hold between machines, the start decides.
TEST(WorkerOrder, OfTwoWorkersInAFolderTheEarlierEnds) {
  const TemporaryFolder folder;
  const StartRank first{1, 0}, again{1, 1}, second{2, 0};
  const FolderClaim claim(folder.path(), {.job_id = "a-job", .attempt = 1}, 0ms, first);
  EXPECT_EQ(claim.loss(), "");
  EXPECT_TRUE(announce_rank(folder.path(), again));
  EXPECT_THAT(claim.loss(), HasSubstr("later start"));
  EXPECT_TRUE(announce_rank(folder.path(), second));
  EXPECT_FALSE(announce_rank(folder.path(), again));
  EXPECT_THROW(FolderClaim(folder.path(), {.job_id = "a-job", .attempt = 1}, 0ms, again),
               FolderTaken);
}

}  // namespace
}  // namespace dccast::jobs
