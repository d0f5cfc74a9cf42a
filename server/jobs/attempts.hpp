#pragma once

#include <chrono>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "dccast/v1/worker.pb.h"
#include "server/jobs/attempt.hpp"
#include "server/jobs/executor.hpp"
#include "server/jobs/ledger.hpp"
#include "server/jobs/settlement.hpp"
#include "server/jobs/watchdog.hpp"

namespace dccast::jobs {

struct AttemptOptions {
  std::filesystem::path jobs_directory;
  int worker_restarts = 2;                      ///< times a job whose worker died is tried again
  std::chrono::milliseconds stop_grace{20000};  ///< from the order to stop to the kill
  std::chrono::milliseconds daemon_patience{0};  ///< a worker runs on without a daemon; 0: it ends
  std::chrono::milliseconds heartbeat_interval{2000};  ///< asked of workers; 0: none
  WatchdogLimits watchdog;
  v1::OtherVersion other_version = v1::BEGIN_ANEW;
  std::string solver{};  ///< identity of the solver that the workers run; empty: not known
  int job_threads = 1;   ///< of a quarter slab
};

/// What happened to a job in its attempt that the queue must know of.
struct AttemptNews {
  std::vector<v1::Job> requeued;  ///< jobs that wait again, their processes gone
  std::string daemon_lacks;       ///< why nothing should be started now; empty: nothing is missing
};

/// The attempts under way, from the start of a worker to the outcome of its job.
///
/// The scheduler's mutex guards everything but hear(), which takes only the attempt's own.
class Attempts {
public:
  using Clock = Attempt::Clock;

  Attempts(AttemptOptions options, JobStore& store, EventLogs& logs, Ledger& ledger,
           Executor& executor);

  /// Starts a worker for a queued job, which is RUNNING from then on.
  /// @throws std::exception  nothing has changed: the job still waits
  void begin(JobRecord record);
  /// Goes on with an attempt whose worker the executor has found again after a restart. A running
  /// job waits for the worker to call, for as long as a new one may take; of any other the worker
  /// is ended, and the job goes on once it is gone.
  void adopt(JobRecord record);
  int count() const { return static_cast<int>(attempts_.size()); }
  int running() const;

  /// The attempt whose worker still decides the outcome of its job; null when there is none.
  Attempt* running(const std::string& job_id);
  /// The attempt whose job is settled, while its process is still there; null when there is none.
  Attempt* leaving(const std::string& job_id);

  /// What someone asks of a running job: kept in the store, then told to the worker.
  /// @throws StoreError  nothing has changed
  void request(Attempt& attempt, RequestedAction action, const std::string& reason);
  /// Lets every worker leave at a checkpoint; its job goes back into the queue.
  void stop_all();
  void order_stop(Attempt& attempt, bool checkpoint);

  /// A worker has called; it gets its order to start. @return its attempt; null for a wrong token
  std::shared_ptr<Attempt> attach(const v1::WorkerMessage::Hello& hello,
                                  std::shared_ptr<WorkerChannel> channel);
  /// Writes a step, a message or a resumption into the event log. Without the scheduler's mutex.
  /// @return what could not be written, the first time; the worker is to be stopped then
  static std::string hear(Attempt& attempt, v1::JobEvent event);
  /// Takes the worker's last word.
  void finish(Attempt& attempt, const v1::WorkerMessage::Finished& finished);
  /// What the worker need not keep any more, when it is time to tell it again. Without the
  /// scheduler's mutex.
  /// @param beat  the worker has said that it is alive
  std::optional<v1::WorkerOrder> acknowledgement(Attempt& attempt, bool beat) const;
  /// The worker has said something, be it only that it is alive. Without the scheduler's mutex.
  static void note_word(Attempt& attempt);
  void note_validity_loss(Attempt& attempt, const v1::ValidityLoss& loss);
  /// The link to a worker has ended.
  void detach(const std::shared_ptr<Attempt>& attempt);

  void worker_started(const std::string& job_id, int number, const std::string& handle);
  void worker_not_started(const std::string& job_id, int number, const std::string& why);
  void worker_ended(const std::string& job_id, int number, const std::string& how);

  /// Kills workers that do not leave in time or hang.
  void kill_overdue(Clock::time_point now);
  Clock::time_point next_deadline() const;
  void forgive_silences(Clock::time_point now);

  /// What has happened since the last call.
  AttemptNews take_news() { return std::exchange(news_, {}); }

private:
  using Finished = v1::WorkerMessage::Finished;
  /// From the end of a worker's process to that of its link, should the link not end by itself.
  static constexpr std::chrono::seconds last_words_time{2};

  std::shared_ptr<Attempt> find(const std::string& job_id, int number) const;
  std::shared_ptr<Attempt> add(JobRecord record, std::shared_ptr<EventLog> log);
  std::shared_ptr<Attempt> expected(const v1::WorkerMessage::Hello& hello) const;
  v1::WorkerOrder start_order(const Attempt& attempt) const;
  v1::WorkerOrder order_or_blame(Attempt& attempt) const;
  void withdraw(const std::shared_ptr<Attempt>& attempt, const std::string& why);
  void kill_hung(Attempt& attempt, const std::string& what);

  AttemptFacts facts_of(Attempt& attempt) const;
  void settle(Attempt& attempt, const Settlement& settlement);
  void count_storage_failure(Attempt& attempt, const Settlement& settlement);
  void conclude(const std::shared_ptr<Attempt>& attempt, const std::string& how);
  std::string missing_artifact(const Attempt& attempt, const Finished& finished) const;

  const AttemptOptions options_;
  JobStore& store_;
  EventLogs& logs_;
  Ledger& ledger_;
  Executor& executor_;
  bool shutting_down_ = false;
  std::map<std::string, std::shared_ptr<Attempt>> attempts_;  ///< by job, until the process is gone
  /// Attempts in a row that ended because something could not be written, and got no further.
  struct StorageFailures {
    int in_a_row = 0;
    std::int64_t reached_step = 0;
  };
  std::map<std::string, StorageFailures> storage_failures_;  ///< by job
  AttemptNews news_;
};

}  // namespace dccast::jobs
