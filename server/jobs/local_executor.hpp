#pragma once

#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

#include "server/jobs/durable_file.hpp"
#include "server/jobs/executor.hpp"

namespace dccast::jobs {

/// Starts workers as child processes of the daemon.
///
/// All of them are children of one thread that lives as long as the daemon: the signal a worker
/// gets when its parent dies (PR_SET_PDEATHSIG) counts the death of the parent *thread*.
class LocalExecutor : public Executor {
public:
  /// @param worker_program  dccast-worker
  /// @param link_address    of the worker link, in gRPC's notation
  LocalExecutor(std::filesystem::path worker_program, std::string link_address);
  /// Kills what is still running and waits for its end.
  ~LocalExecutor() override;

  void set_calls(Calls calls) override { calls_ = std::move(calls); }
  void start(const WorkerLaunch& launch) override;
  void kill(const std::string& job_id, int attempt) override;

private:
  struct Child {
    WorkerLaunch launch;
    pid_t process = 0;
    FileDescriptor handle;  ///< pidfd: readable when the process has ended
  };
  void run();
  void post(std::function<void()> order);
  void spawn(const WorkerLaunch& launch);
  void wait_for_something();
  void collect();

  std::filesystem::path worker_program_;
  std::string link_address_;
  Calls calls_;
  FileDescriptor wake_;  ///< eventfd
  std::mutex mutex_;
  std::deque<std::function<void()>> orders_;
  bool stopping_ = false;
  std::map<std::pair<std::string, int>, Child> children_;  ///< of the thread alone
  std::thread thread_;
};

}  // namespace dccast::jobs
