#include <fmt/core.h>
#include <grp.h>
#include <pwd.h>
#include <signal.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <exception>
#include <filesystem>
#include <iostream>
#include <system_error>

#include "server/access/users.hpp"
#include "server/daemon/daemon.hpp"
#include "server/daemon/settings.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"
#include "server/state/check.hpp"

namespace {

// Exit codes of every program, see README.
constexpr int exit_invalid = 2;
constexpr int exit_damage_left = 3;
constexpr int exit_refused = 4;

/// Blocks the signals that serve() waits for. To be called before any thread starts, because
/// threads inherit the mask.
void prepare_signals() {
  const sigset_t awaited = dccast::daemon::awaited_signals();
  ::pthread_sigmask(SIG_BLOCK, &awaited, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  // The program that started us may ignore SIGCHLD; waitpid() would then return no exit status.
  ::signal(SIGCHLD, SIG_DFL);
  ::signal(SIGXFSZ, SIG_IGN);  // a file at its size limit is an error of write() instead
}

/// Root becomes the owner of the data directory, because the service of that user could not read
/// files written by root.
void become_owner_of(const std::string& data_directory) {
  struct stat status {};
  if (::geteuid() != 0 || ::stat(data_directory.c_str(), &status) != 0 || status.st_uid == 0)
    return;

  const passwd* owner = ::getpwuid(status.st_uid);
  const bool grouped = owner == nullptr ? ::setgroups(0, nullptr) == 0
                                        : ::initgroups(owner->pw_name, status.st_gid) == 0;
  if (!grouped || ::setgid(status.st_gid) != 0 || ::setuid(status.st_uid) != 0)
    throw std::system_error(errno, std::generic_category(),
                            fmt::format("cannot become the owner of {}", data_directory));
}

/// The faults of settings that can be read. @return exit code
int print_config_faults(const dccast::daemon::CommandLine& line,
                        const dccast::v1::DaemonConfig& config) {
  const auto faults = dccast::daemon::faults_beside_settings(config);
  for (const std::string& fault : faults) std::cerr << fault << '\n';
  if (!faults.empty()) return exit_invalid;

  std::cout << (line.config_file.empty() ? "settings" : line.config_file)
            << ": no faults; data directory "
            << std::filesystem::absolute(config.data_directory()).string() << '\n';
  return 0;
}

int run(const dccast::daemon::CommandLine& line, const dccast::v1::DaemonConfig& config) {
  using dccast::daemon::Command;
  const dccast::state::StateFolder folder(config.data_directory());

  int damages = 0;
  switch (line.command) {
    case Command::serve:
      return dccast::daemon::serve(config, line.workers);
    case Command::administrate:
      dccast::daemon::administrate(line.administration, config, std::cout);
      break;
    case Command::check_config:
      return print_config_faults(line, config);
    case Command::check:
      damages = dccast::state::check(
          folder, {.repair = line.repair, .deep = line.deep, .adopt = line.adopt}, std::cout);
      break;
    case Command::backup:
      dccast::state::back_up(folder, line.directory, line.earlier, std::cout);
      break;
    case Command::restore:
      damages = dccast::state::restore(folder, line.directory, std::cout);
      break;
  }

  return damages == 0 ? 0 : exit_damage_left;
}

}  // namespace

int main(int argc, char** argv) {
  const auto line = dccast::daemon::read_command_line(argc, argv);
  if (line.exit_code >= 0) return line.exit_code;

  prepare_signals();
  ::umask(0077);  // files of daemon and workers are accessible to their owner only
  spdlog::set_default_logger(spdlog::stderr_color_mt("dccastd"));

  try {
    const auto config = dccast::daemon::read_config(line.config_file, line.overrides);
    spdlog::set_level(spdlog::level::from_str(config.log().level()));
    if (config.log().format() != dccast::v1::TEXT)
      dccast::log::set_format(config.log().format() == dccast::v1::JSON
                                  ? dccast::log::Format::json
                                  : dccast::log::Format::journal);

    become_owner_of(config.data_directory());
    // A worker that a malicious file controls runs as the same user.
    dccast::jobs::forbid_inspection();
    return run(line, config);
  } catch (const dccast::daemon::InvalidConfig& error) {
    std::cerr << error.what() << '\n';
    return exit_invalid;
  } catch (const dccast::access::Refused& refused) {
    std::cerr << refused.what() << '\n';
    return exit_invalid;
  } catch (const std::exception& error) {
    dccast::log::error("{}", error.what());
    return exit_refused;
  }
}
