#pragma once

#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "server/jobs/executors/worker_process.hpp"

namespace dccast::jobs {

struct WarmWorkerLimits {
  std::filesystem::path scratch{};  ///< where answers may write files; empty: nowhere
  int kept = 1;                     ///< workers that wait or answer while no more are needed
  int answers = 200;  ///< after which a worker is replaced, so that leaks do not add up
  std::int64_t idle_bytes = 512'000'000;  ///< one that holds more after an answer is replaced
};

/// Workers kept warm, for answers and for jobs: starting the program takes 30 ms, an answer may
/// take less than one. One that is gone is replaced before it is missed. Safe to use from several
/// threads; each caller has a worker of its own, so callers decide how many there are.
///
/// All of them are children of one thread that lives as long as this object: the signal a worker
/// gets when its parent dies (PR_SET_PDEATHSIG) counts the death of the parent *thread*.
class WarmWorkers {
public:
  explicit WarmWorkers(std::filesystem::path program, const WarmWorkerLimits& limits = {});

  /// The answer of a worker. @throws WorkerDidNotAnswer  also for one that is refused
  v1::WorkerAnswer ask(
      const v1::WorkerRequest& request, const CallLimits& limits,
      const OnEvent& on_event = [](v1::JobEvent&) {});
  /// A worker for a job, which does not come back: one that has given no answer, since what that
  /// read may have taken it over. @throws WorkerDidNotAnswer  none can be started
  std::unique_ptr<WorkerProcess> take() { return lend(true); }

private:
  using Idle = std::vector<std::unique_ptr<WorkerProcess>>;

  std::unique_ptr<WorkerProcess> lend(bool for_job);
  Idle::iterator idle_for(bool job);
  void give_back(std::unique_ptr<WorkerProcess> worker);
  bool wants_more() const;
  void run(const std::stop_token& stop);

  const std::filesystem::path program_;
  const WarmWorkerLimits limits_;
  std::mutex mutex_;  ///< of all below
  std::condition_variable_any changed_;
  Idle idle_;
  int lent_ = 0;          ///< those that answer
  int waiting_ = 0;       ///< callers, since the last failure
  int jobs_waiting_ = 0;  ///< those of them that want one for a job
  int failures_ = 0;      ///< to start one; those who wait see it change
  bool fails_ = false;    ///< the last try did: the next one is made for a caller
  std::string failure_;
  std::jthread starter_;
};

}  // namespace dccast::jobs
