#include "server/jobs/executors/slurm_commands.hpp"

#include <fmt/core.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <sstream>
#include <string_view>

#include "core/storage/file.hpp"
#include "proto/values/printable.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

constexpr std::string_view name_prefix = "dccast-";
// Slurm itself tries for some 10 s to reach a controller.
constexpr std::chrono::seconds longest_command{30};
/// Largest part of a message of Slurm that a job or the log repeats [bytes].
constexpr std::size_t longest_message = 300;

std::string read_all(const storage::FileDescriptor& file) {
  std::string text(static_cast<std::size_t>(std::max<off_t>(0, ::lseek(file.get(), 0, SEEK_END))),
                   '\0');
  const auto size = ::pread(file.get(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  return text;
}

/// The first line of a text of Slurm, as it may stand in a job and on a terminal.
std::string shown(std::string_view text) {
  return values::escaped(values::shortened(text.substr(0, text.find('\n')), longest_message));
}

/// Whether the message of a failed command shows a refusal. Otherwise the controller may not have
/// been reached, and whether it carried out the request is not known.
bool is_refusal(std::string_view text) {
  for (const char* connection_fault :
       {"contact", "onnect", "imed out", "Socket", "socket", "ommunication", "temporarily",
        "not responding", "munge", "uthentication", "Slurm backup", "credential"})
    if (text.find(connection_fault) != std::string_view::npos) return false;
  return true;
}

/// Runs a command. @return its standard output
std::string run_command(const std::vector<std::string>& words, std::string_view input = {}) {
  const std::string& command = words[0];
  const auto fail = [&command](int error) {
    throw SlurmError(fmt::format("{}: {}", command, ::strerror(error)), false);
  };

  // Files in memory instead of pipes: neither side ever waits for the other.
  std::array<storage::FileDescriptor, 3> files;
  for (auto& file : files) {
    file = storage::FileDescriptor(::memfd_create(command.c_str(), MFD_CLOEXEC));
    if (!file) fail(errno);
  }
  if (::pwrite(files[0].get(), input.data(), input.size(), 0) != static_cast<ssize_t>(input.size()))
    fail(errno);

  // sbatch passes this environment on to the job.
  const auto variables =
      environment(true, {"PATH=", "HOME=", "USER=", "LOGNAME=", "TZ=", "SLURM_"});
  pid_t process = 0;
  if (const int error =
          spawn(words, variables, {files[0].get(), files[1].get(), files[2].get()}, &process))
    throw SlurmError(fmt::format("cannot start {}: {}", command, ::strerror(error)), true);

  const auto status = wait_for(process, longest_command);
  if (!status) throw SlurmError(fmt::format("{} gave no answer in time", command), false);
  if (*status == 0) return read_all(files[1]);

  const std::string message = read_all(files[2]);
  if (message.empty())
    throw SlurmError(fmt::format("{} ended with {}", command, describe_exit(*status)), false);
  throw SlurmError(shown(message), is_refusal(message));
}

/// @return nothing for the name of a job that dccast did not submit
std::optional<SlurmName> parse_name(std::string_view text) {
  const std::size_t dot = text.rfind('.');
  if (!text.starts_with(name_prefix) || dot == std::string_view::npos) return std::nullopt;
  const int attempt = std::atoi(std::string(text.substr(dot + 1)).c_str());
  if (attempt <= 0) return std::nullopt;
  return SlurmName{std::string(text.substr(name_prefix.size(), dot - name_prefix.size())), attempt};
}

/// Converts an exit status to that of waitpid(), from "18944" or "74:0".
int parse_exit_status(const std::string& text) {
  const std::size_t colon = text.find(':');
  const int code = std::atoi(text.c_str());
  return colon == std::string::npos ? code : code << 8 | std::atoi(text.c_str() + colon + 1);
}

/// Quotes a word for the shell.
std::string quote(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The batch script. `exec` makes the worker the batch shell, which Slurm signals before the time
/// limit.
std::string batch_script(const std::string& program, const std::string& folder, int attempt) {
  return fmt::format(
      "#!/bin/sh\n"
      "export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 OMP_THREAD_LIMIT=1\n"
      "exec {} --run {} {}\n",
      quote(program), quote(folder), attempt);
}

}  // namespace

std::string to_string(const SlurmName& name) {
  return fmt::format("{}{}.{}", name_prefix, name.job_id, name.attempt);
}

bool SlurmJob::ended() const {
  constexpr std::array states{"COMPLETED", "FAILED",    "CANCELLED", "TIMEOUT",       "NODE_FAIL",
                              "PREEMPTED", "BOOT_FAIL", "DEADLINE",  "OUT_OF_MEMORY", "REVOKED"};
  return std::ranges::find(states, state) != states.end();
}

bool SlurmJob::runs() const {
  return state == "RUNNING" || state == "COMPLETING" || state == "SIGNALING" ||
         state == "STAGE_OUT";
}

SlurmJobs slurm_jobs() {
  SlurmJobs jobs;
  std::istringstream lines(run_command({"squeue", "--me", "--states=all", "--noheader",
                                        "--Format=Name:|,State:|,Reason:|,exit_code:|"}));
  for (std::string line; std::getline(lines, line);) {
    std::istringstream fields(line);
    std::string name, exit_status;
    SlurmJob job;
    std::getline(fields, name, '|');
    std::getline(fields, job.state, '|');
    std::getline(fields, job.reason, '|');
    std::getline(fields, exit_status, '|');

    const auto parsed_name = parse_name(name);
    if (!parsed_name) continue;
    job.name = *parsed_name;
    job.reason = shown(job.reason);
    job.exit_status = parse_exit_status(exit_status);
    jobs.emplace(parsed_name->job_id, std::move(job));
  }
  return jobs;
}

void slurm_submit(const SlurmName& name, const std::filesystem::path& folder, int cores,
                  const SlurmOptions& options) {
  constexpr double bytes_per_mib = 1048576.0;
  std::vector<std::string> words{
      "sbatch",
      "--parsable",
      fmt::format("--job-name={}", to_string(name)),
      fmt::format("--comment=dccast job {}, attempt {}", name.job_id, name.attempt),
      "--nodes=1",
      "--ntasks=1",
      fmt::format("--cpus-per-task={}", cores),
      "--requeue",
      fmt::format("--signal=B:TERM@{}", options.checkpoint_before.count()),
      fmt::format("--chdir={}", folder.string()),
      "--output=worker.log",
      "--open-mode=append"};

  // Slurm takes whole minutes and MiB: round up.
  if (options.time_limit.count() > 0)
    words.push_back(fmt::format("--time={}", (options.time_limit.count() + 59) / 60));
  if (options.memory_bytes > 0.0)
    words.push_back(fmt::format("--mem={:.0f}M", std::ceil(options.memory_bytes / bytes_per_mib)));

  words.insert(words.end(), options.options.begin(), options.options.end());
  run_command(words, batch_script(options.worker_program, folder, name.attempt));
}

void slurm_cancel(const SlurmName& name) {
  run_command({"scancel", fmt::format("--name={}", to_string(name))});
}

void slurm_terminate(const SlurmName& name) {
  run_command({"scancel", "--batch", "--signal=TERM", fmt::format("--name={}", to_string(name))});
}

}  // namespace dccast::jobs
