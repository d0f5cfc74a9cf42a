#include "server/jobs/spawn.hpp"

#include <signal.h>

#include <string_view>

extern char** environ;

namespace dccast::jobs {

namespace {

/// As the C interface wants it: pointers into `texts`, then a null.
std::vector<char*> null_terminated(std::vector<std::string>& texts) {
  std::vector<char*> pointers;
  for (std::string& text : texts) pointers.push_back(text.data());
  pointers.push_back(nullptr);
  return pointers;
}

}  // namespace

std::vector<std::string> worker_environment() {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (!text.starts_with("DCCAST_WORKER_") && !text.starts_with("OPENBLAS_NUM_THREADS=") &&
        !text.starts_with("OMP_NUM_THREADS=") && !text.starts_with("OMP_THREAD_LIMIT="))
      variables.emplace_back(text);
  }
  // CHOLMOD's supernodal code asks OpenMP for threads whatever OMP_NUM_THREADS says; the limit it
  // keeps to.
  variables.insert(variables.end(),
                   {"OPENBLAS_NUM_THREADS=1", "OMP_NUM_THREADS=1", "OMP_THREAD_LIMIT=1"});
  return variables;
}

int spawn(const std::filesystem::path& program, std::vector<std::string> arguments,
          std::vector<std::string> environment, const posix_spawn_file_actions_t& actions,
          pid_t* process) {
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  sigset_t none, all;
  sigemptyset(&none);
  sigfillset(&all);
  posix_spawnattr_setsigmask(&attributes, &none);
  posix_spawnattr_setsigdefault(&attributes, &all);
  // A group of its own: Ctrl-C in the terminal of a daemon is for the daemon, which tells its own.
  posix_spawnattr_setpgroup(&attributes, 0);
  posix_spawnattr_setflags(&attributes,
                           POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETPGROUP);
  const int error =
      ::posix_spawn(process, program.c_str(), &actions, &attributes,
                    null_terminated(arguments).data(), null_terminated(environment).data());
  posix_spawnattr_destroy(&attributes);
  return error;
}

}  // namespace dccast::jobs
