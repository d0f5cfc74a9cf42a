#include "server/jobs/end_hook.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"
#include "server/jobs/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/worker_process.hpp"

namespace dccast::jobs {

namespace {

constexpr std::size_t most_waiting = 10000;  // then a hook that hangs loses jobs, not memory

std::vector<std::string> environment_of(const v1::Job& job) {
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable)
    if (!std::string_view(*variable).starts_with("DCCAST_")) variables.emplace_back(*variable);
  variables.insert(variables.end(),
                   {"DCCAST_JOB=" + job.id(), "DCCAST_STATE=" + v1::JobState_Name(job.state()),
                    "DCCAST_OWNER=" + job.owner(), "DCCAST_TITLE=" + job.title(),
                    "DCCAST_MAIL=" + job.mail(), "DCCAST_STUDY=" + job.study()});
  return variables;
}

/// @return what waitpid() has of it; nothing: it was killed
std::optional<int> end_of(pid_t process, std::chrono::seconds longest,
                          const std::stop_token& stop) {
  constexpr int look_interval_ms = 100;
  const auto handle = open_process(process);
  const auto end = std::chrono::steady_clock::now() + longest;
  int status = 0;
  while (::waitpid(process, &status, WNOHANG) == 0) {
    if (stop.stop_requested() || std::chrono::steady_clock::now() > end) {
      ::kill(-process, SIGKILL);  // it leads a group of its own
      ::waitpid(process, &status, 0);
      return std::nullopt;
    }
    pollfd ended{handle.get(), POLLIN, 0};
    ::poll(&ended, 1, look_interval_ms);
  }
  return status;
}

}  // namespace

EndHook::EndHook(std::string program, std::chrono::seconds longest)
    : program_(std::move(program)), longest_(longest) {
  if (!program_.empty()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void EndHook::on_transition(const v1::Job& job, v1::JobState from) {
  if (program_.empty() || !is_terminal(job.state()) || is_terminal(from)) return;
  const std::lock_guard lock(mutex_);
  if (ended_.size() >= most_waiting)
    return log::error("job {}: too many jobs wait for {}; it is not run", job.id(), program_);
  ended_.push_back(job);
  changed_.notify_all();
}

void EndHook::run(const std::stop_token& stop) {
  for (;;) {
    v1::Job job;
    {
      std::unique_lock lock(mutex_);
      if (!changed_.wait(lock, stop, [this] { return !ended_.empty(); })) return;
      job = std::move(ended_.front());
      ended_.pop_front();
    }
    run_program(job, stop);
  }
}

void EndHook::run_program(const v1::Job& job, const std::stop_token& stop) const {
  const storage::FileDescriptor nothing(::open("/dev/null", O_RDWR | O_CLOEXEC));
  pid_t process = 0;
  const int error = spawn({program_, job.id(), v1::JobState_Name(job.state())}, environment_of(job),
                          {nothing.get(), nothing.get(), nothing.get()}, &process);
  if (error != 0)
    return log::error("job {}: cannot run {}: {}", job.id(), program_, ::strerror(error));
  const auto status = end_of(process, longest_, stop);
  if (!status)
    log::error("job {}: {} was killed after {} s at most", job.id(), program_, longest_.count());
  else if (*status != 0)
    log::warn("job {}: {} ended with {}", job.id(), program_, describe_exit(*status));
}

}  // namespace dccast::jobs
