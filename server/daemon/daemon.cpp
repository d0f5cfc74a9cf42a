#include "server/daemon/daemon.hpp"

#include <fcntl.h>
#include <signal.h>
#include <spdlog/spdlog.h>
#include <string.h>
#include <sys/file.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <thread>

#include "server/jobs/checker_pool.hpp"
#include "server/jobs/local_executor.hpp"
#include "server/service/grpc_trouble.hpp"
#include "server/service/server.hpp"

namespace dccast::daemon {

namespace {

namespace fs = std::filesystem;

/// The data directory, made if need be, and held: two daemons on one would run every job twice.
class DataDirectory {
public:
  explicit DataDirectory(const fs::path& path) : path_(fs::absolute(path)) {
    fs::create_directories(path_);
    fs::permissions(path_, fs::perms::owner_all);
    lock_ = jobs::open_file(path_ / "lock", O_RDWR | O_CREAT);
    if (::flock(lock_.get(), LOCK_EX | LOCK_NB) != 0)
      throw std::runtime_error("another dccastd uses the data directory " + path_.string() +
                               "; stop it, or set another data_directory");
    fs::remove_all(path_ / "check");  // what checks of a killed daemon left
    fs::create_directories(path_ / "check");
    fs::create_directories(path_ / "jobs");
  }
  fs::path jobs() const { return path_ / "jobs"; }
  fs::path check() const { return path_ / "check"; }
  fs::path store() const { return path_ / "jobs.sqlite"; }
  const fs::path& path() const { return path_; }

private:
  fs::path path_;
  jobs::FileDescriptor lock_;
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

int worker_count(const v1::DaemonConfig& config) {
  if (config.workers() > 0) return config.workers();
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

jobs::SchedulerOptions scheduler_options(const v1::DaemonConfig& config,
                                         const DataDirectory& directory) {
  return {.jobs_directory = directory.jobs(),
          .workers = worker_count(config),
          .maximum_queued = config.maximum_queued(),
          .worker_restarts = config.worker_restarts(),
          .stop_grace = std::chrono::milliseconds(std::lround(config.stop_grace_s() * 1000))};
}

int checker_count(const v1::DaemonConfig& config) {
  if (config.checkers() > 0) return config.checkers();
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

service::Ceilings ceilings(const v1::DaemonConfig& config) {
  const double memory = config.maximum_memory_bytes() > 0.0
                            ? config.maximum_memory_bytes()
                            : service::memory_per_worker(worker_count(config));
  return {config.maximum_nodes(), config.maximum_steps(), memory};
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
  spdlog::warn("maximum_connections = {}: the limit on open files permits {}", wanted, possible);
  return possible;
}

void refuse_open_address(const std::string& listen) {
  if (service::is_loopback(listen)) return;
  throw std::runtime_error(
      "listen = \"" + listen +
      "\" can be reached from other machines, which needs TLS, and this version "
      "has none yet; use a loopback address such as 127.0.0.1:7117 and reach it "
      "through an SSH tunnel");
}

/// @return SIGTERM or SIGINT
int wait_for_signal() {
  sigset_t awaited;
  sigemptyset(&awaited);
  sigaddset(&awaited, SIGTERM);
  sigaddset(&awaited, SIGINT);
  int signal = 0;
  while (::sigwait(&awaited, &signal) != 0) {
  }
  return signal;
}

}  // namespace

int serve(const v1::DaemonConfig& config) {
  service::log_grpc_as_debug();
  refuse_open_address(config.listen());
  const DataDirectory directory(config.data_directory());
  const fs::path worker = worker_program(config);
  const std::size_t connections = connection_count(config);
  jobs::CheckerPool checkers(worker, {.kept = checker_count(config)});
  const service::CaseIntake intake(checkers, config.alloy_directory(), directory.check(),
                                   ceilings(config));
  jobs::JobStore store(directory.store());
  jobs::EventLogs logs(directory.jobs());
  const service::LinkAddress link_address(directory.path());
  jobs::LocalExecutor executor(worker, link_address.grpc_address());
  jobs::Scheduler scheduler(scheduler_options(config, directory), store, logs, executor);
  service::Context context{
      .scheduler = scheduler,
      .logs = logs,
      .store = store,
      .intake = intake,
      .jobs_directory = directory.jobs(),
      .version = DCCAST_VERSION,
      .workers = worker_count(config),
      .maximum_queued = config.maximum_queued(),
      .maximum_message_bytes = static_cast<std::int64_t>(config.maximum_message_bytes()),
      .checkers = checker_count(config),
      .maximum_waiting_checks = config.maximum_waiting_checks(),
      .check_timeout = std::chrono::milliseconds(std::lround(config.check_timeout_s() * 1000)),
      .maximum_connections = connections};
  scheduler.recover();
  service::LinkServer link(scheduler, link_address);
  service::PublicServer server(context, config.listen());
  checkers.warm_up();
  scheduler.start();
  if (!config.port_file().empty()) jobs::replace_file(config.port_file(), server.address() + "\n");
  spdlog::info("dccastd {} serves on {}, data in {}, {} workers", DCCAST_VERSION, server.address(),
               directory.path().string(), context.workers);

  const int signal = wait_for_signal();
  spdlog::info("{}: running jobs stop at a checkpoint and go back into the queue",
               ::strsignal(signal));
  server.announce_end();
  scheduler.shut_down();
  context.leaving = true;
  logs.wake_all();  // watchers are told that the daemon leaves, and from where to watch again
  server.shut_down();
  if (!config.port_file().empty()) ::unlink(config.port_file().c_str());
  spdlog::info("dccastd has stopped");
  return 0;
}

}  // namespace dccast::daemon
