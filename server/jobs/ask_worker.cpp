#include "server/jobs/ask_worker.hpp"

#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <thread>

#include "server/jobs/durable_file.hpp"
#include "server/jobs/process.hpp"
#include "server/jobs/spawn.hpp"

namespace dccast::jobs {

namespace {

/// A file in memory. Unlike a pipe it takes any size at once, so nobody waits for the other side.
FileDescriptor memory_file(const char* name) {
  FileDescriptor file(::memfd_create(name, MFD_CLOEXEC));
  if (!file) throw std::system_error(errno, std::generic_category(), "memfd_create");
  return file;
}

std::string whole(int descriptor) {
  std::string content(static_cast<std::size_t>(::lseek(descriptor, 0, SEEK_END)), '\0');
  content.resize(read_at(descriptor, 0, content));
  return content;
}

/// Waits for a child; kills it when the time is over.
/// @return the status of waitpid(); nothing when it had to be killed
std::optional<int> wait_for(pid_t process, std::chrono::seconds timeout) {
  const auto end = std::chrono::steady_clock::now() + timeout;
  int status = 0;
  auto pause = std::chrono::microseconds(500);
  while (::waitpid(process, &status, WNOHANG) == 0) {
    if (std::chrono::steady_clock::now() > end) {
      ::kill(process, SIGKILL);
      ::waitpid(process, &status, 0);
      return std::nullopt;
    }
    std::this_thread::sleep_for(pause);
    pause = std::min(pause * 2, std::chrono::microseconds(10000));
  }
  return status;
}

}  // namespace

std::string ask_worker(const std::filesystem::path& worker_program, const std::string& mode,
                       std::string_view question, std::chrono::seconds timeout) {
  const FileDescriptor input = memory_file("question");
  const FileDescriptor output = memory_file("answer");
  write_at(input.get(), 0, question);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input.get(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, output.get(), STDOUT_FILENO);
  pid_t process = 0;
  const int error =
      spawn(worker_program, {worker_program, mode}, worker_environment(), actions, &process);
  posix_spawn_file_actions_destroy(&actions);
  const std::string name = worker_program.filename().string() + " " + mode;
  if (error != 0)
    throw WorkerDidNotAnswer("cannot start " + worker_program.string() + ": " + ::strerror(error));
  const auto status = wait_for(process, timeout);
  if (!status)
    throw WorkerDidNotAnswer(name + " took longer than " + std::to_string(timeout.count()) + " s");
  if (*status != 0) throw WorkerDidNotAnswer(name + " ended with " + describe_exit(*status));
  return whole(output.get());
}

}  // namespace dccast::jobs
