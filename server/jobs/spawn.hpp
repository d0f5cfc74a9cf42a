#pragma once

#include <spawn.h>
#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dccast::jobs {

/// The daemon's environment without what is a worker's own, and with one thread for BLAS: jobs
/// share the cores, and the solver was measured to gain nothing from two.
std::vector<std::string> worker_environment();

/// posix_spawn with signals as a program expects them: default handlers, none blocked (the daemon
/// blocks those it waits for). @return 0 or an error number
int spawn(const std::filesystem::path& program, std::vector<std::string> arguments,
          std::vector<std::string> environment, const posix_spawn_file_actions_t& actions,
          pid_t* process);

}  // namespace dccast::jobs
