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

/// Bounds on processes, memory and answers.
struct WarmWorkerLimits {
  int kept = 1;       ///< number of idle and busy workers that are kept
  int answers = 200;  ///< after which a worker is replaced, so that leaks do not accumulate
  std::int64_t idle_bytes = 512'000'000;  ///< an idle worker that uses more is replaced [bytes]
};

/// Pool of started workers, for requests and for jobs: starting the program takes 30 ms, an answer
/// may take less than 1 ms. A worker that is used up is replaced in advance. Safe to use from
/// several threads. Each caller has a worker of its own, so the callers decide how many there are.
///
/// All workers are children of one thread that lives as long as this object, because the signal at
/// the death of the parent (PR_SET_PDEATHSIG) is sent at the end of the parent *thread*.
class WarmWorkers {
public:
  /// @param program  path of dccast-worker
  explicit WarmWorkers(std::filesystem::path program, const WarmWorkerLimits& limits = {});

  /// Asks a worker. @throws WorkerDidNotAnswer  also if the worker refuses to answer
  v1::WorkerAnswer ask(
      const v1::WorkerRequest& request, const CallLimits& limits,
      const OnEvent& on_event = [](v1::JobEvent&) {});
  /// Takes a worker out of the pool, for a job. It has given no answer before: a file that it read
  /// for an answer may have taken control of it. @throws WorkerDidNotAnswer  none can be started
  std::unique_ptr<WorkerProcess> take() { return lend({.is_job = true}); }

private:
  using Idle = std::vector<std::unique_ptr<WorkerProcess>>;
  /// What a worker is for. One that has answered may have been taken over by what it read: it gets
  /// no job, and no folder of another job.
  struct Need {
    bool is_job = false;
    std::string folder{};  ///< see WorkerProcess
  };

  /// Takes an idle worker out; waits for one to be started if none suits.
  std::unique_ptr<WorkerProcess> lend(const Need& need);
  /// An idle worker: for an answer preferably one whose caches are warm.
  Idle::iterator choose_idle(const Need& need);
  /// Ends the oldest worker that has answered, so that another one has a place.
  void make_room();
  /// Takes a worker back, unless enough are kept; null: it was handed a job or has ended.
  void give_back(std::unique_ptr<WorkerProcess> worker);
  /// Whether the starter should start another worker.
  bool wants_more() const;
  /// The starter's loop.
  void run(const std::stop_token& stop);

  const std::filesystem::path program_;
  const WarmWorkerLimits limits_;
  std::mutex mutex_;  ///< guards all below
  std::condition_variable_any changed_;
  Idle idle_;
  int lent_ = 0;        ///< workers that are answering
  int waiting_ = 0;     ///< callers that have waited since the last failure
  int failures_ = 0;    ///< failed starts; waiting callers see the number change
  bool fails_ = false;  ///< the last start failed: the next one is made on demand only
  std::string failure_;
  std::jthread starter_;
};

}  // namespace dccast::jobs
