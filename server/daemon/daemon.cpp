#include "server/daemon/daemon.hpp"

#include <fmt/core.h>
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
#include <vector>

#include "core/storage/file.hpp"
#include "proto/values/local_socket.hpp"
#include "server/daemon/metrics.hpp"
#include "server/daemon/service_manager.hpp"
#include "server/intake/case_intake.hpp"
#include "server/intake/uploads.hpp"
#include "server/jobs/executors/local_executor.hpp"
#include "server/jobs/executors/slurm_executor.hpp"
#include "server/jobs/executors/warm_workers.hpp"
#include "server/jobs/folder/job_description.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/queue/ended_jobs.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/server.hpp"
#include "server/state/index.hpp"
#include "server/studies/lines.hpp"
#include "server/studies/studies.hpp"

namespace dccast::daemon {

namespace {

namespace fs = std::filesystem;

/// The data directory, created if necessary, and locked.
class DataDirectory : public state::StateFolder {
public:
  explicit DataDirectory(const fs::path& path) : StateFolder(path), lock_(created()) {
    state::set_strange_folders_aside(*this);
    fs::remove_all(check());  // files left by the checks of a killed daemon
    fs::create_directories(check());
    fs::create_directories(jobs());
  }

private:
  const StateFolder& created() const {
    state::make_state_folder(*this);
    return *this;
  }

  state::StateLock lock_;
};

fs::path worker_program(const v1::DaemonConfig& config) {
  const fs::path program = config.workers().program().empty()
                               ? fs::read_symlink("/proc/self/exe").parent_path() / "dccast-worker"
                               : fs::absolute(config.workers().program());
  if (::access(program.c_str(), X_OK) != 0)
    throw std::runtime_error(
        fmt::format("the worker program {} cannot be run; set workers.program", program.string()));
  return program;
}

/// Raises the limit on file descriptors as far as the system permits. @return the limit
rlim_t raise_descriptor_limit() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_NOFILE, &limit) != 0) return 0;
  limit.rlim_cur = limit.rlim_max;
  ::setrlimit(RLIMIT_NOFILE, &limit);
  ::getrlimit(RLIMIT_NOFILE, &limit);
  return limit.rlim_cur;
}

/// Largest number of connections. Half of the descriptors are reserved for jobs: logs, workers,
/// results. A connection needs three: the client's, and both ends of the relay's socket pair.
int connection_count(int wanted) {
  const auto possible = raise_descriptor_limit() / 6;
  if (static_cast<rlim_t>(wanted) <= possible) return wanted;
  log::warn("limits.maximum_connections = {} is lowered to {}: more exceed the limit on open files",
            wanted, possible);
  return static_cast<int>(possible);
}

/// Fills in the settings whose defaults depend on this machine.
v1::DaemonConfig resolve(v1::DaemonConfig settings) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const auto number = [](int wanted, int otherwise) { return wanted > 0 ? wanted : otherwise; };

  v1::DaemonConfig::Workers& workers = *settings.mutable_workers();
  workers.set_count(number(workers.count(), cores));
  v1::DaemonConfig::Checks& checks = *settings.mutable_checks();
  checks.set_workers(number(checks.workers(), cores));
  v1::DaemonConfig::Queries& queries = *settings.mutable_queries();
  queries.set_workers(number(queries.workers(), cores));
  // A query usually has the machine to itself.
  queries.set_threads(number(queries.threads(), std::min(2, cores)));

  v1::DaemonConfig::PerCase& per_case = *settings.mutable_per_case();
  if (per_case.maximum_memory_bytes() <= 0.0)
    per_case.set_maximum_memory_bytes(intake::memory_per_worker(workers.count()));
  v1::DaemonConfig::Limits& limits = *settings.mutable_limits();
  limits.set_maximum_connections(connection_count(limits.maximum_connections()));
  return settings;
}

std::chrono::milliseconds milliseconds(double seconds) {
  return std::chrono::milliseconds(std::lround(seconds * 1000));
}

std::chrono::seconds whole_seconds(double seconds) {
  return std::chrono::seconds(std::llround(std::ceil(seconds)));
}

/// @return null if the daemon starts all workers itself
std::unique_ptr<jobs::SlurmExecutor> slurm_executor(const v1::DaemonConfig& config,
                                                    const DataDirectory& directory,
                                                    jobs::Executor& local) {
  if (config.executor() != v1::SLURM) return nullptr;
  std::istringstream words(config.slurm().options());
  return std::make_unique<jobs::SlurmExecutor>(
      local, jobs::SlurmOptions{
                 .jobs_directory = fs::absolute(directory.jobs()),
                 .worker_program = worker_program(config),
                 .jobs = config.slurm().jobs(),
                 .options = {std::istream_iterator<std::string>(words), {}},
                 .time_limit = whole_seconds(config.slurm().time_limit_s()),
                 .checkpoint_before = whole_seconds(config.slurm().checkpoint_before_s()),
                 .memory_bytes = config.slurm().memory_bytes(),
                 .interval = milliseconds(config.slurm().interval_s()),
                 .silence = std::max(jobs::SlurmOptions().silence,
                                     4 * milliseconds(config.workers().heartbeat_interval_s()))});
}

jobs::SchedulerOptions scheduler_options(const v1::DaemonConfig& config,
                                         const WorkerPolicy& workers,
                                         const DataDirectory& directory,
                                         const std::string& solver) {
  return {
      .attempts = {.jobs_directory = directory.jobs(),
                   .worker_restarts = config.workers().restarts(),
                   .stop_grace = milliseconds(config.workers().stop_grace_s()),
                   .daemon_patience = milliseconds(workers.patience_s),
                   .heartbeat_interval = milliseconds(config.workers().heartbeat_interval_s()),
                   .watchdog = {.hello = milliseconds(config.workers().start_timeout_s()),
                                .heartbeat = milliseconds(config.workers().heartbeat_timeout_s()),
                                .stall = milliseconds(config.workers().stall_timeout_s())},
                   .other_version = config.workers().other_version(),
                   .solver = solver,
                   .job_threads = config.workers().threads(),
                   .first_threads = config.queries().threads(),
                   .maximum_time_s = config.per_case().maximum_time_s(),
                   .worker_memory_bytes = std::llround(config.workers().memory_bytes()),
                   .worker_file_bytes = std::llround(config.workers().file_size_bytes())},
      .maximum_queued = config.limits().maximum_queued(),
      .maximum_waiting_bytes = std::llround(config.limits().maximum_waiting_bytes()),
      .minimum_free_bytes = std::llround(config.limits().minimum_free_bytes()),
      .share_half_life = whole_seconds(config.per_user().share_half_life_s()),
      .maximum_running_per_user = config.per_user().maximum_running(),
      .maximum_followed = config.limits().maximum_followed(),
      .maximum_followed_per_user = config.per_user().maximum_followed()};
}

/// Asks a worker for the identity of its solver, by which stored answers are found, and for its
/// sandbox; both are empty if it does not answer.
/// @throws jobs::WorkerDidNotAnswer  no worker can be started
v1::WorkerAnswer identify_worker(jobs::WarmWorkers& workers) {
  constexpr std::chrono::seconds longest{10};
  v1::WorkerRequest request;
  request.mutable_name_solver();
  try {
    return workers.ask(request, {.deadline = std::chrono::steady_clock::now() + longest});
  } catch (const jobs::WorkerDidNotAnswer& error) {
    if (error.why() == jobs::WorkerDidNotAnswer::Why::not_started) throw;
    log::warn("the solver of the workers is unknown; stored answers are not used: {}",
              error.what());
    return {};
  }
}

/// Address for the users of this machine: "unix:PATH".
std::string local_address(const v1::DaemonConfig& config) {
  return config.listen().socket().empty() ? values::unix_scheme + values::default_socket_path()
                                          : config.listen().socket();
}

/// Listens over TLS if the settings give an address.
class TlsListener {
public:
  explicit TlsListener(const v1::DaemonConfig& config) : config_(config) {
    if (config.listen().tls().empty()) return;
    files_ = prepare_tls(config);
    for (const std::string& fault : tls_faults(config, files_)) log::warn("{}", fault);
    listener_.emplace(config.listen().tls());
    if (files_.own)
      renewer_ = std::jthread([this](const std::stop_token& stop) { run_renewer(stop); });
  }

  std::optional<service::TlsListening> listening() {
    if (!listener_) return std::nullopt;
    return service::TlsListening{*listener_, {files_.certificate, files_.key, files_.client_ca}};
  }
  std::string address() const { return listener_ ? listener_->address() : ""; }
  const std::string& certificate() const { return files_.certificate; }

private:
  /// Renews a certificate of our own a month before its end.
  void run_renewer(const std::stop_token& stop) {
    constexpr std::chrono::hours interval{1};
    std::mutex mutex;
    std::condition_variable_any ended;
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, stop, interval, [&] { return stop.stop_requested(); })) {
      try {
        prepare_tls(config_);
      } catch (const std::exception& error) {
        log::error("cannot renew the certificate, trying again in an hour: {}", error.what());
      }
    }
  }

  const v1::DaemonConfig config_;
  TlsFiles files_;
  std::optional<relay::Listener> listener_;
  std::jthread renewer_;
};

/// Owner of a job, study or line, if it exists.
template <typename Found>
std::optional<std::string> owner(const Found& found) {
  return found ? std::optional(found->owner()) : std::nullopt;
}

/// @return SIGTERM, SIGINT, or SIGUSR1, which leaves running jobs to their workers
int wait_for_signal() {
  const sigset_t awaited = awaited_signals();
  int signal = 0;
  while (::sigwait(&awaited, &signal) != 0) {
  }
  return signal;
}

/// The parts that run jobs and studies, in the order of their construction. The constructor
/// recovers the state of the last daemon.
struct JobSide {
  JobSide(const v1::DaemonConfig& settings, const WorkerPolicy& policy);

  const DataDirectory directory;
  jobs::WarmWorkers warm_workers;  ///< one for each concurrent answer, and one for the next job
  const v1::WorkerAnswer worker;
  const intake::CaseIntake intake;
  intake::Uploads uploads;
  const std::unique_ptr<jobs::JobStore> store;
  jobs::EventLogs logs;
  jobs::ReadingsLogs readings;
  jobs::Precedence precedence;
  jobs::LocalExecutor local;
  const std::unique_ptr<jobs::SlurmExecutor> slurm;
  jobs::Executor& executor;
  jobs::Tally tally;
  jobs::EndHook end_hook;
  jobs::Scheduler scheduler;
  studies::StudyStore study_store;
  studies::Studies studies;
  studies::Lines lines;
};

/// Adds the castings to their lines whose jobs a daemon has written just before it was killed. They
/// have not ended: a casting takes longer than the start of a daemon.
void add_lost_castings(jobs::JobStore& store, const state::StateFolder& folder,
                       studies::Lines& lines) {
  for (const jobs::JobRecord& record : store.unfinished()) {
    const v1::Job& job = record.job;
    const auto of_job = folder.jobs() / job.id();
    if (!jobs::follows_readings(of_job)) continue;
    try {
      const v1::Following following = jobs::ReadingsReader(of_job).following();
      v1::Case complete;
      if (!following.line().empty() && jobs::read_complete_case(of_job, complete))
        lines.add_lost(following.line(), job.owner(),
                       studies::make_line_casting(job, following, complete));
    } catch (const std::exception& error) {
      log::warn("job {} may be missing on its line: {}", job.id(), error.what());
    }
  }
}

JobSide::JobSide(const v1::DaemonConfig& settings, const WorkerPolicy& policy)
    : directory(settings.data_directory()),
      warm_workers(worker_program(settings),
                   {.kept = settings.checks().workers() + settings.queries().workers() + 1}),
      worker(identify_worker(warm_workers)),
      intake(warm_workers, settings.alloy_directory(), directory.check(),
             {settings.per_case().maximum_nodes(), settings.per_case().maximum_steps(),
              settings.per_case().maximum_memory_bytes()}),
      uploads(directory.uploads(),
              {.largest = std::llround(settings.per_case().maximum_attachment_bytes()),
               .of_user = std::llround(settings.per_user().maximum_uploads_bytes()),
               .all = std::llround(settings.limits().maximum_uploads_bytes()),
               .minimum_free = std::llround(settings.limits().minimum_free_bytes()),
               .lifetime = milliseconds(settings.retention().upload_lifetime_s())}),
      store(state::open_store(directory)),
      logs(directory.jobs()),
      readings(directory.jobs()),
      local(warm_workers, settings.workers().count(), precedence),
      slurm(slurm_executor(settings, directory, local)),
      executor(slurm ? static_cast<jobs::Executor&>(*slurm) : local),
      end_hook(settings.job_end_hook()),
      scheduler(scheduler_options(settings, policy, directory, worker.solver()), *store, logs,
                executor),
      study_store(directory.store()),
      studies({.directory = directory.studies(),
               .jobs_directory = directory.jobs(),
               .check_timeout = milliseconds(settings.checks().timeout_s())},
              study_store, scheduler, intake),
      lines(directory.lines()) {
  scheduler.observe_transitions([this](const v1::Job& job, v1::JobState from) {
    tally.count(job, from);
    if (jobs::is_terminal(job.state())) readings.close(job.id());
    end_hook.on_transition(job, from);
  });

  add_lost_castings(*store, directory, lines);
  scheduler.recover();
  studies.requests().recover();
}

/// Decides about access.
struct AccessSide {
  AccessSide(const v1::DaemonConfig& config, JobSide& jobs);

  access::UserStore users;
  access::AuditLog audit;
  access::Authority authority;
  service::Gate gate;
};

/// @throws std::runtime_error  there is no such user
std::optional<unsigned> web_user_id(const std::string& name) {
  if (name.empty()) return std::nullopt;
  const auto id = service::user_id(name);
  if (!id)
    throw std::runtime_error(fmt::format(
        "access.web_user = \"{}\" is no user of this machine; permitted: the system user of "
        "dccast-web, or \"\" for none",
        name));
  return id;
}

AccessSide::AccessSide(const v1::DaemonConfig& config, JobSide& jobs)
    : users(jobs.directory.path()),
      audit(jobs.directory.path()),
      authority(users, {.local_role = config.access().local_role(),
                        .own_user = service::user_name(::geteuid()),
                        .reads_own_only = config.access().read() == v1::OWN}),
      gate(authority, audit,
           {.calls_per_s = config.per_user().maximum_calls_per_s(),
            .streams = static_cast<std::size_t>(config.limits().maximum_streams()),
            .streams_per_user = static_cast<std::size_t>(config.per_user().maximum_streams())},
           {.job = [&jobs](const std::string& id) { return owner(jobs.scheduler.find(id)); },
            .study =
                [&jobs](const std::string& id) { return owner(jobs.studies.requests().find(id)); },
            .line = [&jobs](const std::string& id) { return jobs.lines.owner(id); }},
           web_user_id(config.access().web_user())) {}

/// Objects that the calls of the service use.
service::Context make_context(const v1::DaemonConfig& config, JobSide& jobs, service::Gate& gate) {
  const bool by_slurm = config.executor() == v1::SLURM;
  return {.settings = config,
          .scheduler = jobs.scheduler,
          .logs = jobs.logs,
          .readings = jobs.readings,
          .store = *jobs.store,
          .studies = jobs.studies,
          .lines = jobs.lines,
          .intake = jobs.intake,
          .uploads = jobs.uploads,
          .gate = gate,
          .warm_workers = jobs.warm_workers,
          .precedence = jobs.precedence,
          .solver = jobs.worker.solver(),
          .worker_sandbox = jobs.worker.sandbox(),
          .query_directory = jobs.directory.check(),
          .jobs_directory = jobs.directory.jobs(),
          .version = DCCAST_VERSION,
          .workers = by_slurm ? config.slurm().jobs() : config.workers().count()};
}

/// @return the endpoint, which ends with the last reference; null if the settings name none
std::shared_ptr<void> serve_metrics_if_set(const v1::DaemonConfig& config, JobSide& jobs,
                                           service::Context& context, const TlsListener& tls) {
  if (config.listen().metrics().empty()) return nullptr;
  return serve_metrics(config.listen().metrics(),
                       {.context = context,
                        .tally = jobs.tally,
                        .data_directory = jobs.directory.path(),
                        .certificate = tls.certificate(),
                        .shows_owners = config.access().read() != v1::OWN});
}

/// Warns of tokens that end within fourteen days.
void warn_of_tokens(access::UserStore& users) {
  constexpr std::int64_t before_s = 14 * 86400;
  const std::int64_t now = jobs::now().seconds();
  const v1::Users all = users.users();
  for (const v1::User& user : all.user())
    for (const v1::Credential& token : user.credential())
      if (!token.enrolment() && token.expires_unix() > now && token.expires_unix() < now + before_s)
        log::warn(
            "the token {} of {} on {} ends in {} days; its user renews it: dccast login --renew",
            token.id(), user.name(), token.machine(), (token.expires_unix() - now) / 86400);
}

void log_start(const v1::DaemonConfig& config, const std::string& local, const std::string& tls,
               const service::Context& context, const fs::path& data) {
  if (!config.listen().port_file().empty())
    storage::replace_file(config.listen().port_file(), tls.empty()
                                                           ? fmt::format("{}\n", local)
                                                           : fmt::format("{}\n{}\n", local, tls));

  log::info("dccastd {} serves on {}{}, data in {}, {} workers", DCCAST_VERSION, local,
            tls.empty() ? "" : ", over TLS on " + tls, data.string(), context.workers);
  // Empty if no worker has answered, which was logged before.
  if (!context.worker_sandbox.empty()) log::info("workers: {}", context.worker_sandbox);
}

/// Treatment of running workers when the daemon ends.
enum class WorkersAtEnd { stop, stay };

void stop_serving(service::PublicServer& server, service::Context& context, JobSide& jobs,
                  WorkersAtEnd workers) {
  server.announce_end();
  jobs.studies.stop();
  if (workers == WorkersAtEnd::stay) {
    jobs.scheduler.let_workers_run();
    jobs.executor.let_workers_run();
  } else {
    jobs.scheduler.shut_down();
  }

  // Informs watchers that the daemon ends, and after which event to continue.
  context.leaving = true;
  jobs.studies.notifier().wake_all();
  jobs.logs.wake_all();
  server.shut_down();
}

/// @return a description of the queue; nothing if its thread does not respond
std::string queue_status(jobs::Scheduler& scheduler, std::chrono::milliseconds longest) {
  if (!scheduler.is_responsive(longest)) return {};
  const std::string held = scheduler.held();
  const std::string status =
      fmt::format("{} queued, {} running", scheduler.queued(), scheduler.running());
  return held.empty() ? status : fmt::format("{}; the queue is held: {}", status, held);
}

/// Workers in Slurm stay: they do not depend on a daemon, and a released machine is hard to get
/// again. Workers with --worker-patience 0 end with the daemon.
WorkersAtEnd decide_on_workers(int signal, const v1::DaemonConfig& config,
                               const WorkerPolicy& workers) {
  if (config.executor() == v1::SLURM) return WorkersAtEnd::stay;
  const bool is_wanted = signal == SIGUSR1 || workers.left_running;
  return is_wanted && workers.patience_s > 0.0 ? WorkersAtEnd::stay : WorkersAtEnd::stop;
}

void serve_until_signal(service::PublicServer& server, service::Context& context, JobSide& side,
                        const WorkerPolicy& workers, ServiceManager& manager) {
  const v1::DaemonConfig& config = context.settings;
  manager.ready([&](auto longest) { return queue_status(side.scheduler, longest); });

  const int signal = wait_for_signal();
  const WorkersAtEnd at_end = decide_on_workers(signal, config, workers);
  const char* consequence = at_end == WorkersAtEnd::stay
                                ? "running jobs go on for the next dccastd"
                                : "running jobs stop at a checkpoint and go back into the queue";
  log::info("{}: {}", ::strsignal(signal), consequence);

  manager.stopping(consequence);
  stop_serving(server, context, side, at_end);
  if (!config.listen().port_file().empty()) ::unlink(config.listen().port_file().c_str());
  log::info("dccastd has stopped");
}

}  // namespace

sigset_t awaited_signals() {
  sigset_t awaited;
  sigemptyset(&awaited);
  for (const int signal : {SIGTERM, SIGINT, SIGUSR1}) sigaddset(&awaited, signal);
  return awaited;
}

std::vector<std::string> faults_beside_settings(const v1::DaemonConfig& config) {
  std::vector<std::string> faults;
  const auto check = [&faults](const auto& act) {
    try {
      act();
    } catch (const std::exception& error) {
      faults.emplace_back(error.what());
    }
  };

  check([&] { worker_program(config); });
  check([&] {
    if (!config.alloy_directory().empty() && !fs::is_directory(config.alloy_directory()))
      throw std::runtime_error("alloy_directory = " + config.alloy_directory() +
                               ": there is no such directory");
  });
  check([&] {
    if (config.tls().certificate().empty()) return;
    for (const std::string& fault : tls_faults(config, prepare_tls(config)))
      faults.push_back(fault);
  });
  return faults;
}

int serve(const v1::DaemonConfig& given, const WorkerPolicy& workers) {
  ServiceManager manager;
  service::log_grpc_as_debug();

  const v1::DaemonConfig config = resolve(given);
  JobSide jobs(config, workers);

  // A caller that connects before the recovery has ended would only wait.
  const relay::Listener local(local_address(config));
  TlsListener tls(config);
  AccessSide access(config, jobs);
  service::Context context = make_context(config, jobs, access.gate);
  service::PublicServer server(context, local, tls.listening());

  jobs.scheduler.observe_removal(
      [&context](const v1::Job& job) { service::learn_before_removal(context, job); });
  jobs.scheduler.refuse_owners(
      [&access](const v1::Job& job) { return access.authority.refusal_of_owner(job); });
  jobs.scheduler.start();
  jobs.studies.start();
  const jobs::Retention retention({.time = whole_seconds(config.retention().keep_time_s()),
                                   .bytes = std::llround(config.retention().keep_size_bytes())},
                                  *jobs.store, jobs.scheduler);
  const auto metrics = serve_metrics_if_set(config, jobs, context, tls);

  warn_of_tokens(access.users);
  log_start(config, local.address(), tls.address(), context, jobs.directory.path());
  serve_until_signal(server, context, jobs, workers, manager);
  return 0;
}

}  // namespace dccast::daemon
