#include "server/daemon/daemon.hpp"

#include <pwd.h>
#include <signal.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <condition_variable>
#include <filesystem>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <utility>

#include "core/storage/file.hpp"
#include "proto/values/address.hpp"
#include "server/daemon/administration.hpp"
#include "server/daemon/metrics.hpp"
#include "server/daemon/service_manager.hpp"
#include "server/intake/case_intake.hpp"
#include "server/jobs/ended_jobs.hpp"
#include "server/jobs/local_executor.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/slurm_executor.hpp"
#include "server/jobs/warm_workers.hpp"
#include "server/service/server.hpp"
#include "server/state/index.hpp"
#include "server/studies/studies.hpp"

namespace dccast::daemon {

namespace {

namespace fs = std::filesystem;

/// The data directory, made if need be, and held.
class DataDirectory : public state::StateFolder {
public:
  explicit DataDirectory(const fs::path& path) : StateFolder(path), lock_(made()) {
    fs::remove_all(check());  // what checks of a killed daemon left
    fs::create_directories(check());
    fs::create_directories(jobs());
  }

private:
  const StateFolder& made() const {
    state::make_state_folder(*this);
    return *this;
  }

  state::StateLock lock_;
};

fs::path worker_program(const v1::DaemonConfig& config) {
  const fs::path program = config.worker_program().empty()
                               ? fs::read_symlink("/proc/self/exe").parent_path() / "dccast-worker"
                               : fs::absolute(config.worker_program());
  if (::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error("the worker program " + program.string() +
                             " cannot be run; set worker_program");
  return program;
}

/// @param wanted  of the settings; 0: one per core
int number_or_cores(int wanted) {
  if (wanted > 0) return wanted;
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

/// One query has the machine to itself more often than not.
int query_threads(const v1::DaemonConfig& config) {
  return config.query_threads() > 0 ? config.query_threads() : std::min(2, number_or_cores(0));
}

int worker_count(const v1::DaemonConfig& config) {
  return number_or_cores(config.workers());
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(std::lround(seconds * 1000));
}

/// Jobs that run at once.
int capacity(const v1::DaemonConfig& config) {
  return config.executor() == v1::SLURM ? config.slurm_jobs() : worker_count(config);
}

std::chrono::seconds whole_seconds(double seconds) {
  return std::chrono::seconds(std::llround(std::ceil(seconds)));
}

/// @return null where the daemon starts all workers itself
std::unique_ptr<jobs::SlurmExecutor> slurm_executor(const v1::DaemonConfig& config,
                                                    const DataDirectory& directory,
                                                    jobs::Executor& local) {
  if (config.executor() != v1::SLURM) return nullptr;
  std::istringstream words(config.slurm_options());
  return std::make_unique<jobs::SlurmExecutor>(
      local,
      jobs::SlurmOptions{.jobs_directory = fs::absolute(directory.jobs()),
                         .worker_program = worker_program(config),
                         .jobs = config.slurm_jobs(),
                         .options = {std::istream_iterator<std::string>(words), {}},
                         .time_limit = whole_seconds(config.slurm_time_limit_s()),
                         .checkpoint_before = whole_seconds(config.slurm_checkpoint_before_s()),
                         .memory_bytes = config.slurm_memory_bytes(),
                         .interval = milliseconds(config.slurm_interval_s()),
                         .silence = std::max(jobs::SlurmOptions().silence,
                                             4 * milliseconds(config.heartbeat_interval_s()))});
}

jobs::SchedulerOptions scheduler_options(const v1::DaemonConfig& config,
                                         const WorkerPolicy& workers,
                                         const DataDirectory& directory,
                                         const std::string& solver) {
  return {.attempts = {.jobs_directory = directory.jobs(),
                       .worker_restarts = config.worker_restarts(),
                       .stop_grace = milliseconds(config.stop_grace_s()),
                       .daemon_patience = milliseconds(workers.patience_s),
                       .heartbeat_interval = milliseconds(config.heartbeat_interval_s()),
                       .watchdog = {.hello = milliseconds(config.worker_hello_timeout_s()),
                                    .heartbeat = milliseconds(config.heartbeat_timeout_s()),
                                    .stall = milliseconds(config.stall_timeout_s())},
                       .other_version = config.other_version(),
                       .solver = solver,
                       .job_threads = config.job_threads(),
                       .first_threads = query_threads(config),
                       .maximum_time_s = config.maximum_time_s(),
                       .worker_memory_bytes = std::llround(config.worker_memory_bytes()),
                       .worker_file_bytes = std::llround(config.worker_file_bytes())},
          .maximum_queued = config.maximum_queued(),
          .maximum_waiting_bytes = std::llround(config.maximum_waiting_bytes()),
          .minimum_free_bytes = std::llround(config.minimum_free_bytes()),
          .share_half_life = whole_seconds(config.share_half_life_s()),
          .maximum_running_per_user = config.maximum_running_per_user()};
}

studies::StudyOptions study_options(const v1::DaemonConfig& config,
                                    const DataDirectory& directory) {
  return {.directory = directory.studies(),
          .jobs_directory = directory.jobs(),
          .check_timeout = milliseconds(config.check_timeout_s())};
}

intake::Ceilings ceilings(const v1::DaemonConfig& config) {
  const double memory = config.maximum_memory_bytes() > 0.0
                            ? config.maximum_memory_bytes()
                            : intake::memory_per_worker(worker_count(config));
  return {config.maximum_nodes(), config.maximum_steps(), memory};
}

/// What the workers compute with, for answers that are found again, and what holds them; empty when
/// none answers. @throws jobs::WorkerDidNotAnswer  there is no worker that could be asked
v1::WorkerAnswer introduction_of(jobs::WarmWorkers& workers) {
  constexpr std::chrono::seconds longest{10};
  v1::WorkerRequest request;
  request.mutable_name_solver();
  try {
    return workers.ask(request, {.deadline = std::chrono::steady_clock::now() + longest});
  } catch (const jobs::WorkerDidNotAnswer& error) {
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    log::warn("queries are answered by a run each time: {}", error.what());
    return {};
  }
}

/// As many file descriptors as the system permits.
rlim_t raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ::getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur;
}

/// Half of the descriptors stay for jobs: their logs, their workers, their results.
std::size_t connection_count(const v1::DaemonConfig& config) {
  const auto wanted = static_cast<std::size_t>(config.maximum_connections());
  const auto possible = static_cast<std::size_t>(raise_descriptor_limit() / 2);
  if (wanted <= possible) return wanted;
  log::warn("maximum_connections = {}: the limit on open files permits {}", wanted, possible);
  return possible;
}

void refuse_open_address(const std::string& listen) {
  if (values::is_loopback(listen)) return;
  throw std::runtime_error("listen = \"" + listen +
                           "\" can be reached from other machines, and has no TLS; set listen_tls "
                           "to it, and listen to a loopback address such as 127.0.0.1:7117");
}

std::string own_user_name() {
  const passwd* entry = ::getpwuid(::geteuid());
  return entry == nullptr ? std::to_string(::geteuid()) : entry->pw_name;
}

access::Authority::Policy policy(const v1::DaemonConfig& config) {
  return {.local_role = config.local_role(),
          .own_user = own_user_name(),
          .reads_own_only = config.read() == v1::OWN};
}

/// Listens over TLS where the settings have it so.
class TlsListener {
public:
  explicit TlsListener(const v1::DaemonConfig& config) : config_(config) {
    if (config.listen_tls().empty()) return;
    files_ = prepare_tls(config);
    listener_.emplace(config.listen_tls());
    if (files_.own) keeper_ = std::jthread([this](const std::stop_token& stop) { keep(stop); });
  }

  std::optional<service::TlsListening> listening() {
    if (!listener_) return std::nullopt;
    return service::TlsListening{*listener_,
                                 static_cast<std::size_t>(config_.maximum_connections_per_peer()),
                                 files_.certificate, files_.key, files_.client_ca};
  }
  std::string address() const { return listener_ ? listener_->address() : ""; }
  const std::string& certificate() const { return files_.certificate; }

private:
  /// Renews a certificate of our own a month before its end.
  void keep(const std::stop_token& stop) {
    constexpr std::chrono::hours between_looks{1};
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, stop, between_looks, [&] { return stop.stop_requested(); })) {
      try {
        prepare_tls(config_);
      } catch (const std::exception& error) {
        log::error("the certificate cannot be renewed: {}", error.what());
      }
    }
  }

  const v1::DaemonConfig config_;
  TlsFiles files_;
  std::optional<service::Listener> listener_;
  std::jthread keeper_;
};

service::Gate::Limits gate_limits(const v1::DaemonConfig& config) {
  return {.calls_per_s = config.maximum_calls_per_s(),
          .streams = static_cast<std::size_t>(config.maximum_streams()),
          .streams_per_user = static_cast<std::size_t>(config.maximum_streams_per_user())};
}

/// Of a job or study, where there is one.
template <typename Found>
std::optional<std::string> owner_of(const Found& found) {
  return found ? std::optional(found->owner()) : std::nullopt;
}

/// @return SIGTERM or SIGINT, or SIGUSR1, which leaves running jobs to their workers
int wait_for_signal() {
  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGTERM);
  sigaddset(&awaited, SIGINT);
  sigaddset(&awaited, SIGUSR1);
  int signal = 0;
  while (::sigwait(&awaited, &signal) != 0) {
  }
  return signal;
}

/// What has to stop, and in an order: see stop_serving().
struct Serving {
  service::PublicServer& server;
  studies::Studies& studies;
  jobs::Scheduler& scheduler;
  service::Context& context;
  jobs::EventLogs& logs;
  jobs::Executor& executor;
};

/// @param sandbox  what holds the workers; empty where none has answered, which is logged before
void log_start(const v1::DaemonConfig& config, const std::string& local, const std::string& tls,
               const DataDirectory& directory, const std::string& sandbox) {
  if (!config.port_file().empty())
    storage::replace_file(config.port_file(), local + "\n" + (tls.empty() ? "" : tls + "\n"));
  log::info("dccastd {} serves on {}{}, data in {}, {} workers", DCCAST_VERSION, local,
            tls.empty() ? "" : ", over TLS on " + tls, directory.path().string(), capacity(config));
  if (!sandbox.empty()) log::info("workers: {}", sandbox);
}

/// As many as may answer at once, so that nothing others do keeps a query waiting, and one for the
/// next job.
int warm_worker_count(const v1::DaemonConfig& config) {
  return number_or_cores(config.checkers()) + number_or_cores(config.query_workers()) + 1;
}

/// @param left_running  workers stay for the next daemon
void stop_jobs(const Serving& of, bool left_running) {
  if (!left_running) return of.scheduler.shut_down();
  of.scheduler.let_workers_run();
  of.executor.let_workers_run();
}

void stop_serving(const Serving& of, bool left_running) {
  of.server.announce_end();
  of.studies.stop();
  stop_jobs(of, left_running);
  of.context.leaving = true;
  of.studies.notifier().wake_all();
  of.logs.wake_all();  // watchers learn that the daemon leaves, and from where to watch again
  of.server.shut_down();
}

/// @return the queue in words; nothing when it does not turn
std::string queue_status(jobs::Scheduler& scheduler, std::chrono::milliseconds longest) {
  if (!scheduler.turns(longest)) return {};
  const std::string held = scheduler.held();
  return std::to_string(scheduler.queued()) + " queued, " + std::to_string(scheduler.running()) +
         " running" + (held.empty() ? "" : "; the queue is held: " + held);
}

/// Those of Slurm need no daemon, and a machine that is given back is hard to get again. Workers
/// without patience end with their daemon.
bool leaves_workers(int signal, const v1::DaemonConfig& config, const WorkerPolicy& workers) {
  if (config.executor() == v1::SLURM) return true;
  return (signal == SIGUSR1 || workers.left_running) && workers.patience_s > 0.0;
}

void serve_until_signal(const Serving& serving, ServiceManager& manager,
                        const v1::DaemonConfig& config, const WorkerPolicy& workers) {
  manager.ready([&](auto longest) { return queue_status(serving.scheduler, longest); });
  const int signal = wait_for_signal();
  const bool left_running = leaves_workers(signal, config, workers);
  const std::string jobs = left_running
                               ? "running jobs go on for the next dccastd"
                               : "running jobs stop at a checkpoint and go back into the queue";
  log::info("{}: {}", ::strsignal(signal), jobs);
  manager.stopping(jobs);
  stop_serving(serving, left_running);
  if (!config.port_file().empty()) ::unlink(config.port_file().c_str());
  log::info("dccastd has stopped");
}

jobs::RetentionOptions retention_options(const v1::DaemonConfig& config,
                                         const DataDirectory& directory) {
  return {.jobs_directory = directory.jobs(),
          .time = whole_seconds(config.keep_time_s()),
          .bytes = std::llround(config.keep_size_bytes())};
}

/// @return null where the settings ask for none
std::unique_ptr<MetricsServer> serve_metrics(const v1::DaemonConfig& config,
                                             MetricSources sources) {
  if (config.metrics().empty()) return nullptr;
  auto server = std::make_unique<MetricsServer>(config.metrics(), std::move(sources));
  log::info("metrics on http://{}/metrics", server->address());
  return server;
}

void set_limits(service::Context& context, const v1::DaemonConfig& config) {
  context.workers = capacity(config);
  context.maximum_queued = config.maximum_queued();
  context.maximum_queued_per_user = config.maximum_queued_per_user();
  context.maximum_time_s = config.maximum_time_s();
  context.maximum_disk_per_user_bytes = config.maximum_disk_per_user_bytes();
  context.token_lifetime_s = std::llround(config.token_lifetime_s());
  context.maximum_message_bytes = static_cast<std::int64_t>(config.maximum_message_bytes());
  context.checks_at_once = number_or_cores(config.checkers());
  context.queries_at_once = number_or_cores(config.query_workers());
  context.query_threads = query_threads(config);
  context.maximum_waiting_checks = config.maximum_waiting_checks();
  context.check_timeout = milliseconds(config.check_timeout_s());
}

}  // namespace

int serve(const v1::DaemonConfig& config, const WorkerPolicy& workers) {
  ServiceManager manager;
  service::log_grpc_as_debug();
  refuse_open_address(config.listen());
  const DataDirectory directory(config.data_directory());
  const std::size_t connections = connection_count(config);
  jobs::WarmWorkers warm_workers(worker_program(config),
                                 {.scratch = directory.check(), .kept = warm_worker_count(config)});
  const v1::WorkerAnswer worker = introduction_of(warm_workers);
  const intake::CaseIntake intake(warm_workers, config.alloy_directory(), directory.check(),
                                  ceilings(config));
  const auto opened_store = state::open_store(directory);
  jobs::JobStore& store = *opened_store;
  jobs::EventLogs logs(directory.jobs());
  jobs::LocalExecutor local(warm_workers, worker_count(config));
  const auto slurm = slurm_executor(config, directory, local);
  jobs::Executor& executor = slurm ? static_cast<jobs::Executor&>(*slurm) : local;
  jobs::Tally tally;
  jobs::EndHook end_hook(config.job_end_hook());
  jobs::Scheduler scheduler(scheduler_options(config, workers, directory, worker.solver()), store,
                            logs, executor);
  scheduler.observe_transitions([&](const v1::Job& job, v1::JobState from) {
    tally.count(job, from);
    end_hook.on_transition(job, from);
  });
  studies::StudyStore study_store(directory.store());
  studies::Studies studies(study_options(config, directory), study_store, scheduler, intake);
  scheduler.recover();
  studies.recover();
  service::Listener listener(config.listen());
  TlsListener tls(config);
  access::UserStore users(directory.path());
  access::AuditLog audit(directory.path());
  access::Authority authority(users, policy(config));
  service::Gate gate(authority, audit, gate_limits(config),
                     {.job = [&](const std::string& id) { return owner_of(scheduler.find(id)); },
                      .study = [&](const std::string& id) { return owner_of(studies.find(id)); }},
                     listener.address());
  service::Context context{.scheduler = scheduler,
                           .logs = logs,
                           .store = store,
                           .studies = studies,
                           .intake = intake,
                           .gate = gate,
                           .warm_workers = warm_workers,
                           .solver = worker.solver(),
                           .worker_sandbox = worker.sandbox(),
                           .query_directory = directory.check(),
                           .jobs_directory = directory.jobs(),
                           .version = DCCAST_VERSION,
                           .maximum_connections = connections};
  set_limits(context, config);
  service::PublicServer server(context, listener, tls.listening());
  scheduler.start();
  studies.start();
  const jobs::Retention retention(retention_options(config, directory), store, scheduler);
  const auto metrics = serve_metrics(config, {context, tally, directory.path(), tls.certificate()});
  log_start(config, listener.address(), tls.address(), directory, worker.sandbox());
  serve_until_signal({server, studies, scheduler, context, logs, executor}, manager, config,
                     workers);
  return 0;
}

}  // namespace dccast::daemon
