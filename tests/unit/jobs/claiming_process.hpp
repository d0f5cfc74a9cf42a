#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <thread>

#include "server/jobs/executors/worker_claim.hpp"
#include "tests/support/eventually.hpp"

namespace dccast::jobs {

/// A process that claims the folder of a job and does nothing else, as a worker that outlives its
/// daemon; gone at the end of a test.
class ClaimingProcess {
public:
  ClaimingProcess(const std::filesystem::path& folder, const WorkerClaim& claim) : id_(::fork()) {
    if (id_ == 0) hold(folder, claim);
    const auto has_claimed = [&] {
      const auto holder = find_holder(folder);
      return holder && holder->claim;
    };
    EXPECT_TRUE(eventually(has_claimed)) << "the process did not claim " << folder;
  }
  ClaimingProcess(const ClaimingProcess&) = delete;
  ~ClaimingProcess() {
    ::kill(id_, SIGKILL);
    ::waitpid(id_, nullptr, 0);
  }
  pid_t id() const { return id_; }
  /// Not at once: another thread waits for its end by then.
  void kill_soon() {
    killer_ = std::jthread([this] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));  // see above
      ::kill(id_, SIGKILL);
    });
  }

private:
  [[noreturn]] static void hold(const std::filesystem::path& folder, const WorkerClaim& claim) {
    const FolderClaim held(folder, claim, std::chrono::milliseconds(0));
    for (;;) ::pause();
  }

  pid_t id_;
  std::jthread killer_;
};

}  // namespace dccast::jobs
