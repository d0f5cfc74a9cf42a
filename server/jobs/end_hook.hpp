#pragma once

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <string>
#include <thread>

#include "dccast/v1/job.pb.h"

namespace dccast::jobs {

/// Runs an administrator's program once for each job that has ended, one after the other, as
/// `PROGRAM ID STATE` with DCCAST_JOB, DCCAST_STATE, DCCAST_OWNER, DCCAST_TITLE, DCCAST_MAIL and
/// DCCAST_STUDY in its environment. No shell reads a text of a user. It is started at most once for
/// a job: what waits when the daemon ends is lost. Safe to use from several threads.
class EndHook {
public:
  /// @param program  empty: none
  /// @param longest  then it is killed with what it has started
  explicit EndHook(std::string program, std::chrono::seconds longest = std::chrono::seconds(60));
  /// For Ledger::observe_transitions().
  void on_transition(const v1::Job& job, v1::JobState from);

private:
  void run(const std::stop_token& stop);
  void run_program(const v1::Job& job, const std::stop_token& stop) const;

  const std::string program_;
  const std::chrono::seconds longest_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::deque<v1::Job> ended_;
  std::jthread thread_;
};

}  // namespace dccast::jobs
