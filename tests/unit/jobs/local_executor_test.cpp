#include "server/jobs/executors/local_executor.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <condition_variable>
#include <filesystem>
#include <mutex>
#include <thread>
#include <vector>

#include "core/storage/file.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/jobs/claiming_process.hpp"

namespace dccast::jobs {
namespace {

/// Ends of workers as the executor reports them.
struct Ends {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::string> ended;

  Executor::Calls calls() {
    return {.not_started = [](auto&&...) {},
            .ended =
                [this](const std::string& job_id, int attempt, const WorkerExit& exit) {
                  const std::lock_guard lock(mutex);
                  ended.push_back(job_id + " " + std::to_string(attempt) + ": " + exit.how);
                  changed.notify_all();
                },
            .waits = [](auto&&...) {},
            .stopped = [](auto&&...) {}};
  }
  std::string wait_for_one() {
    std::unique_lock lock(mutex);
    changed.wait_for(lock, std::chrono::seconds(10), [this] { return !ended.empty(); });
    return ended.empty() ? "nothing" : ended.front();
  }
};

class LocalExecutorAdoption : public testing::Test {
protected:
  Adoption adopt(int attempt = 1, bool wanted = true) {
    return executor_.adopt({.job_id = "a-job", .attempt = attempt, .folder = folder_.path()},
                           wanted);
  }

  TemporaryFolder folder_;
  Ends ends_;
  WarmWorkers workers_{"/bin/true"};
  Precedence precedence_;
  LocalExecutor executor_{workers_, 1, precedence_};
};

TEST_F(LocalExecutorAdoption, LeadsOnAWorkerThatClaimsTheFolder) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(), Adoption::found);
  executor_.kill("a-job", 1);
  EXPECT_EQ(ends_.wait_for_one(), "a-job 1: an unknown exit code");
  EXPECT_FALSE(find_holder(folder_.path()));
}

TEST_F(LocalExecutorAdoption, EndsAWorkerThatItCannotLeadOn) {
  const WorkerClaim right{.job_id = "a-job", .attempt = 2};
  WorkerClaim other_job = right, other_attempt = right, other_protocol = right;
  other_job.job_id = "another";
  other_attempt.attempt = 1;
  other_protocol.protocol = worker_protocol + 1;
  for (const WorkerClaim& claim : {other_job, other_attempt, other_protocol}) {
    ClaimingProcess worker(folder_.path(), claim);
    EXPECT_EQ(adopt(2), Adoption::gone);
    EXPECT_FALSE(find_holder(folder_.path()));
  }
  ClaimingProcess worker(folder_.path(), right);

  EXPECT_EQ(adopt(2, false), Adoption::gone) << "its job does not run";
  EXPECT_FALSE(find_holder(folder_.path()));
}

TEST_F(LocalExecutorAdoption, LeavesItToTheNextDaemonWhenTold) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(), Adoption::found);
  executor_.let_workers_run();
  EXPECT_TRUE(find_holder(folder_.path()));
  EXPECT_TRUE(ends_.ended.empty());
}

TEST_F(LocalExecutorAdoption, PassesARequestToStopOn) {
  executor_.set_calls(ends_.calls());
  ClaimingProcess worker(folder_.path(), {.job_id = "a-job", .attempt = 1});
  EXPECT_EQ(adopt(), Adoption::found);
  executor_.stop("a-job", 1);  // SIGTERM, for which this process has no handler
  EXPECT_EQ(ends_.wait_for_one(), "a-job 1: an unknown exit code");
}

/// Runs workers of a program that reads no order and claims nothing by itself.
class LocalExecutorStops : public testing::Test {
protected:
  LocalExecutorStops() {
    executor_.set_calls(
        {.not_started = [](auto&&...) {},
         .ended = [](auto&&...) {},
         .waits = [](auto&&...) {},
         .stopped = [this](auto&&, int, const std::string& why) { is_stopped_ = !why.empty(); }});
  }
  static std::filesystem::path made_in(const std::filesystem::path& folder) {
    storage::write_file(folder / "program", "#!/bin/sh\nexec sleep 60\n", 0700);
    return folder / "program";
  }
  /// What the worker does when it takes its job.
  void claim() const { storage::write_file(folder_.path() / "worker.lock", "3 1 a-job\n"); }

  TemporaryFolder folder_;
  const std::filesystem::path program_ = made_in(folder_.path());
  std::atomic<bool> is_stopped_ = false;
  WarmWorkers workers_{program_};
  Precedence precedence_;
  LocalExecutor executor_{workers_, 1, precedence_};
};

TEST_F(LocalExecutorStops, NoWorkerThatHasNotClaimedItsFolderYet) {
  const auto urgent = precedence_.enter({.urgency = Urgency::quick,
                                         .on_change = [](const auto&) {},
                                         .processor_s = [] { return std::nullopt; }});
  executor_.start({.job_id = "a-job", .attempt = 1, .folder = folder_.path()});
  EXPECT_TRUE(stays([&] { return !is_stopped_; }, std::chrono::milliseconds(200)))
      << "nothing would continue it";

  claim();
  EXPECT_TRUE(eventually([&] { return is_stopped_.load(); }));
}

}  // namespace
}  // namespace dccast::jobs
