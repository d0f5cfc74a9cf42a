#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/core.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/util/delimited_message_util.h>
#include <signal.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <iostream>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>

#include "core/casting/case/case_check.hpp"
#include "core/casting/findings/judge.hpp"
#include "core/casting/forecast.hpp"
#include "core/casting/simulation.hpp"
#include "core/casting/stored_run.hpp"
#include "core/results/column_file.hpp"
#include "core/storage/storage_error.hpp"
#include "server/jobs/executors/precedence.hpp"
#include "server/jobs/executors/worker_claim.hpp"
#include "server/jobs/executors/worker_process.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/processes.hpp"
#include "server/translate/translate.hpp"
#include "server/worker/run.hpp"
#include "server/worker/run_facts.hpp"
#include "server/worker/sandbox.hpp"
#include "server/worker/stored_frames.hpp"

namespace dccast::worker {

namespace {

constexpr int exit_not_begun = 1;
constexpr int exit_link_broken = 1;
constexpr int exit_usage = 2;

/// A worker without a claim on the folder of a job dies with its daemon, because the next daemon
/// would not find it. Checkpoints are complete at any moment, so this costs some steps at most.
/// @return false if the daemon has ended before
bool tie_to_parent(const std::string& parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  return std::to_string(::getppid()) == parent;
}

/// Lowers the priority: less urgent runs get the processor time that queries leave. This cannot be
/// undone.
void lower_priority(int steps) {
  errno = 0;
  if (steps > 0 && ::nice(steps) == -1 && errno != 0)
    std::cerr << "dccast-worker: runs at the priority of queries: " << ::strerror(errno) << '\n';
}

/// The daemon stops a worker while more urgent runs need the machine, and may die before it
/// continues it. The system then sends SIGHUP and SIGCONT, as to any stopped process group that
/// loses its parent: the first one would end this process. A daemon that has adopted this worker is
/// not its parent, so the worker also has a timer that continues it.
void limit_stops() {
  ::signal(SIGHUP, SIG_IGN);

  sigevent event{};
  event.sigev_notify = SIGEV_SIGNAL;
  event.sigev_signo = SIGCONT;
  timer_t timer;
  const timespec interval{.tv_sec = jobs::longest_stop.count(), .tv_nsec = 0};
  const itimerspec regularly{.it_interval = interval, .it_value = interval};
  if (::timer_create(CLOCK_MONOTONIC, &event, &timer) != 0 ||
      ::timer_settime(timer, 0, &regularly, nullptr) != 0)
    std::cerr << "dccast-worker: has no timer that continues it: " << ::strerror(errno) << '\n';
}

/// Redirects the messages of this process to the log of a job. If the log cannot be opened, the job
/// runs all the same.
void redirect_messages(const std::filesystem::path& log) {
  // Opening neither waits for the reader of a pipe nor follows a link.
  constexpr int flags = O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW;
  const int file = ::open(log.c_str(), flags, 0600);
  if (file < 0) return;
  ::dup2(file, STDOUT_FILENO);
  ::dup2(file, STDERR_FILENO);
  ::close(file);
}

/// Reads the case of a job, as the daemon has completed it. @throws std::runtime_error
void read_case(v1::SolveCase& order) {
  const auto description = jobs::read_job_description(order.directory());
  jobs::require_files_to_run(order.directory(), description);
  if (!order.mutable_case_()->ParseFromString(description.complete_case))
    throw std::runtime_error(fmt::format("the case in {} cannot be read", jobs::description_file));
}

v1::RunEnd read_and_run(v1::SolveCase& order, JobRun& run) {
  try {
    read_case(order);
  } catch (const std::system_error&) {
    throw;  // the disk cannot be read, which is no fault of the job
  } catch (const std::runtime_error& error) {
    return failed_run(v1::Finding::STORAGE,
                      fmt::format("the folder of the job is damaged: {}", error.what()));
  }
  return run_job(order, run);
}

// Time until a worker that was just killed releases the folder. On another machine it must first
// see that it is superseded, and the file server must drop its lock.
constexpr std::chrono::seconds longest_claim{5};
constexpr std::chrono::seconds longest_claim_elsewhere{120};

std::string isolation;  ///< what isolate() has reported

/// @throws jobs::FolderTaken, std::system_error
void run_in_folder(v1::SolveCase& order, std::optional<jobs::StartRank> rank) {
  const jobs::FolderClaim claim(order.directory(), {order.job_id(), order.attempt()},
                                rank ? longest_claim_elsewhere : longest_claim, rank);

  // With a claim the next daemon finds this process, so it may outlive the present one.
  if (order.daemon_patience_s() > 0.0) ::prctl(PR_SET_PDEATHSIG, 0);

  const std::string confinement = confine_to({.own = order.directory()});
  const std::string bounds =
      bound({.memory_bytes = order.memory_bytes(), .file_bytes = order.file_bytes()});
  std::cerr << fmt::format("dccast-worker: {}, {}, {}\n", isolation, confinement, bounds)
            << std::flush;

  const auto begin = std::chrono::system_clock::now();
  JobRun run(order, claim);
  v1::RunEnd end = read_and_run(order, run);
  write_run_facts(order, order.directory(), begin);
  if (end.outcome() == v1::RunEnd::FAILED && met_file_bound())
    // Not a storage failure, for which the queue would wait: the file will never fit.
    end =
        failed_run(v1::Finding::INVALID_CASE,
                   fmt::format("the case makes a file larger than {}: store fewer frames, or have "
                               "workers.file_size raised in the settings of dccastd",
                               storage::megabytes(order.file_bytes())));

  end.set_attempt(order.attempt());
  end.set_solver(casting::solver_identity());
  run.end(std::move(end));

  // Without destructors: the next job waits for the end of this process.
  ::_exit(0);
}

/// Runs a job, after which this process ends. @return its exit code
/// @param rank  of a worker that Slurm has started
int run_whole_job(v1::SolveCase& order, std::optional<jobs::StartRank> rank = {}) {
  JobRun::prepare_signals();
  redirect_messages(std::filesystem::path(order.directory()) / "worker.log");
  std::cerr << fmt::format("{:%Y-%m-%d %H:%M:%SZ} attempt {}\n", fmt::gmtime(::time(nullptr)),
                           order.attempt());
  try {
    run_in_folder(order, rank);
    return 0;
  } catch (const std::system_error& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return storage::is_memory_fault(error.code()) ? jobs::exit_out_of_memory : jobs::exit_storage;
  }
}

/// Runs the job whose order is in a folder, on a machine that Slurm chose. It does not depend on a
/// daemon.
int run_ordered(const std::string& folder, int attempt) {
  auto order = jobs::read_order(folder);
  if (!order || order->attempt() != attempt) {
    std::cerr << "dccast-worker: " << folder << " has no order for attempt " << attempt << '\n';
    return exit_not_begun;
  }

  ::prctl(PR_SET_NAME, "dccast-job");
  if (jobs::has_begun(folder, attempt)) {
    std::cerr << "dccast-worker: attempt " << attempt << " has begun before\n";
    return jobs::exit_begun_before;
  }

  order->set_directory(folder);
  return run_whole_job(*order, jobs::StartRank{.attempt = attempt});
}

/// The name of a busy process in lists of processes.
const char* process_name(const v1::WorkerRequest& request) {
  if (request.has_solve()) return request.solve().job_id().empty() ? "dccast-query" : "dccast-job";
  return request.has_check() ? "dccast-check" : "dccast-read";
}

/// Rank of a local worker: it needs one only if an earlier start of the job, which may still be
/// running in Slurm, has announced its own.
std::optional<jobs::StartRank> rank_if_needed(const v1::SolveCase& order) {
  const auto file = std::filesystem::path(order.directory()) / jobs::rank_file;
  if (::access(file.c_str(), F_OK) != 0) return std::nullopt;
  return jobs::StartRank{.attempt = order.attempt()};
}

/// A run without a job: every event is sent to the daemon. The daemon kills this process to stop
/// it.
///
/// A message wakes the daemon, which costs more processor time than the message itself, so steps
/// that follow each other quickly are sent together.
class EventsToDaemon : public RunLink {
public:
  explicit EventsToDaemon(int socket) : stream_(socket) {}
  void send(v1::JobEvent event) override {
    const bool may_wait = event.has_step() && Clock::now() - sent_ < together;
    v1::WorkerAnswer answer;
    *answer.mutable_event() = std::move(event);
    const bool written =
        google::protobuf::util::SerializeDelimitedToZeroCopyStream(answer, &stream_);
    if (!written || !(may_wait || stream_.Flush())) ::_exit(exit_link_broken);
    if (!may_wait) sent_ = Clock::now();
  }
  casting::Order order() const override { return casting::Order::go_on; }

private:
  using Clock = std::chrono::steady_clock;
  static constexpr std::chrono::milliseconds together{5};

  google::protobuf::io::FileOutputStream stream_;  ///< its destructor sends waiting events
  Clock::time_point sent_{};
};

/// Checks a case. With findings, it also judges whether a plant could cast a case that can be run.
v1::ValidateCaseResponse check_case(const v1::CheckCase& asked) {
  const std::filesystem::path folder = asked.directory();
  const casting::Case c = translate::to_core(asked.case_(), folder / jobs::attachments_folder);
  v1::ValidateCaseResponse verdict = translate::to_proto(
      casting::check(c, {asked.faulty_keys().begin(), asked.faulty_keys().end()}));

  if (!asked.findings() || verdict.faults_size() > 0 || asked.faulty_keys_size() > 0)
    return verdict;

  for (const auto& found : {casting::findings_of_case(c), casting::forecast(c)})
    for (const results::Finding& finding : found)
      *verdict.add_findings() = translate::to_proto(finding);
  return verdict;
}

v1::QueryResultResponse read_frame(const v1::ReadFrame& asked) {
  const StoredFrames stored(asked.directory(), asked.running());
  v1::QueryResultResponse found;
  found.mutable_frame_time_s()->Add(stored.times().begin(), stored.times().end());

  const std::size_t count = stored.times().size();
  const std::size_t number = asked.number() == 0 ? count : std::size_t(asked.number());
  if (number < 1 || number > count) return found;

  stored.visit(number - 1, 1, [&](const results::Frame& frame) {
    *found.mutable_frame() = asked.field().empty()
                                 ? translate::to_proto(frame, stored.header())
                                 : translate::field_to_proto(frame, asked.field());
    if (asked.drawing() && asked.field().empty()) translate::make_drawing(*found.mutable_frame());
  });
  return found;
}

v1::ProbeResultResponse probe_frames(const v1::ProbeFrames& asked) {
  const StoredFrames stored(asked.directory(), asked.running());
  const v1::ProbeResultRequest& request = asked.request();
  v1::ProbeResultResponse found;
  if (stored.times().empty()) return found;

  found.set_dimension(stored.header().dimension);
  for (const auto& point : request.points())
    if (point.coordinate_m_size() != found.dimension()) return found;

  std::size_t first = 0, count = stored.times().size();
  if (request.instant_case() != v1::ProbeResultRequest::INSTANT_NOT_SET) {
    first = request.last() ? count - 1 : stored.nearest(request.time_s());
    count = 1;
  }
  stored.visit(first, count,
               [&](const results::Frame& frame) { translate::add_probed(frame, request, found); });
  return found;
}

/// Answers a request that is not the run of a job. May throw anything.
void fill(v1::WorkerAnswer& answer, const v1::WorkerRequest& request) {
  switch (request.request_case()) {
    case v1::WorkerRequest::kCheck:
      *answer.mutable_verdict() = check_case(request.check());
      return;
    case v1::WorkerRequest::kReadFrame:
      *answer.mutable_stored() = read_frame(request.read_frame());
      return;
    case v1::WorkerRequest::kProbeFrames:
      *answer.mutable_probed() = probe_frames(request.probe_frames());
      return;
    case v1::WorkerRequest::kWriteTable:
      return results::write_columns(request.write_table().path(),
                                    translate::to_table(request.write_table().study()));
    case v1::WorkerRequest::kSolve: {
      lower_priority(request.solve().nice());
      EventsToDaemon events(STDIN_FILENO);
      *answer.mutable_run_end() = run_job(request.solve(), events);
      return;
    }
    case v1::WorkerRequest::kNameSolver:
      return answer.set_solver(casting::solver_identity());
    case v1::WorkerRequest::REQUEST_NOT_SET:
      throw std::runtime_error("there is no such request");
  }
}

/// Answers requests until the daemon closes the link, or a request is the run of a job.
int serve_daemon() {
  google::protobuf::io::FileInputStream input(STDIN_FILENO);
  std::string confined;
  for (;;) {
    ::prctl(PR_SET_NAME, "dccast-worker");

    v1::WorkerRequest request;
    if (!google::protobuf::util::ParseDelimitedFromZeroCopyStream(&request, &input, nullptr))
      return 0;

    ::prctl(PR_SET_NAME, process_name(request));
    if (!request.solve().job_id().empty()) {
      v1::SolveCase& order = *request.mutable_solve();
      limit_stops();
      lower_priority(order.nice());
      return run_whole_job(order, rank_if_needed(order));
    }

    // A file that is read for an answer may take control of this process: it never gets a job, nor
    // the folder of another request.
    if (confined.empty()) {
      const std::filesystem::path folder = jobs::folder_of(request);
      const bool writes = request.has_write_table() || request.has_solve();
      confined = confine_to(writes ? Reach{.own = folder} : Reach{.readable = folder});
    }

    v1::WorkerAnswer answered;
    try {
      fill(answered, request);
    } catch (const std::exception& error) {
      answered.set_refused(error.what());
    }

    if (request.has_name_solver()) answered.set_sandbox(fmt::format("{}, {}", isolation, confined));
    if (!google::protobuf::util::SerializeDelimitedToFileDescriptor(answered, STDIN_FILENO))
      return exit_link_broken;
  }
}

/// @return the exit code, see main()
int work(int argc, char** argv) {
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write() instead
  name_memory_exhaustion();
  ::unsetenv("HDF5_USE_FILE_LOCKING");  // the library would lock its files, which is refused
  isolation = isolate();

  try {
    if (argc == 4 && argv[1] == std::string("--run"))
      return run_ordered(argv[2], std::atoi(argv[3]));

    const std::string parent = jobs::take_variable("DCCAST_WORKER_PARENT");
    if (parent.empty()) {
      std::cerr << "dccast-worker is started by dccastd, see dccastd --help\n";
      return exit_usage;
    }

    return tie_to_parent(parent) ? serve_daemon() : exit_daemon_gone;
  } catch (const std::bad_alloc&) {
    std::cerr << "dccast-worker: out of memory\n";
    ::_exit(jobs::exit_out_of_memory);  // libraries that lacked memory may never end orderly
  } catch (const std::exception& error) {
    std::cerr << "dccast-worker: " << error.what() << '\n';
    return exit_not_begun;
  }
}

}  // namespace

}  // namespace dccast::worker

/// The worker program. dccastd starts it, with its own process id in the environment, and sends it
/// requests on its standard input: worker.proto. As `dccast-worker --run FOLDER ATTEMPT` it runs
/// codes:
///   0  the daemon has closed the link, or the end of the run is in the event log of the job
///   1  it could not begin: another worker writes into the folder of the job, for example
///  70  the folder of the job is gone, a later start of the job has it, or no daemon
///     came in time and the run did not stop
///  75  the attempt has begun before
///  71, 74  jobs::exit_out_of_memory, jobs::exit_storage
/// Once it has claimed the folder of a job it outlives the daemon, as long as the order permits.
int main(int argc, char** argv) {
  return dccast::worker::work(argc, argv);
}
