#include "server/jobs/executors/slurm_commands.hpp"

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
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

constexpr std::string_view name_prefix = "dccast-";
// Slurm itself tries for some 10 s to reach a controller.
constexpr std::chrono::seconds longest_command{30};

std::string content_of(const storage::FileDescriptor& file) {
  std::string text(static_cast<std::size_t>(std::max<off_t>(0, ::lseek(file.get(), 0, SEEK_END))),
                   '\0');
  const auto size = ::pread(file.get(), text.data(), text.size(), 0);
  text.resize(static_cast<std::size_t>(std::max<ssize_t>(0, size)));
  return text;
}

/// Whether a failed command says that the controller has refused, and not that it was not reached.
bool is_refusal(std::string_view text) {
  for (const char* doubt :
       {"contact", "onnect", "imed out", "Socket", "socket", "ommunication", "temporarily",
        "not responding", "munge", "uthentication", "Slurm backup", "credential"})
    if (text.find(doubt) != std::string_view::npos) return false;
  return true;
}

/// @return what it prints
std::string run_command(const std::vector<std::string>& words, std::string_view input = {}) {
  std::array<storage::FileDescriptor, 3> files;
  for (auto& file : files) {
    file = storage::FileDescriptor(::memfd_create(words[0].c_str(), MFD_CLOEXEC));
    if (!file) throw SlurmError(words[0] + ": " + ::strerror(errno), false);
  }
  if (::pwrite(files[0].get(), input.data(), input.size(), 0) != static_cast<ssize_t>(input.size()))
    throw SlurmError(words[0] + ": " + ::strerror(errno), false);
  pid_t process = 0;
  // Jobs get this environment, too.
  if (const int error =
          spawn(words, environment(true, {"PATH=", "HOME=", "USER=", "LOGNAME=", "TZ=", "SLURM_"}),
                {files[0].get(), files[1].get(), files[2].get()}, &process))
    throw SlurmError("cannot start " + words[0] + ": " + ::strerror(error), true);
  const auto status = wait_for(process, longest_command);
  if (!status) throw SlurmError(words[0] + " gave no answer in time", false);
  if (*status == 0) return content_of(files[1]);
  const std::string said = content_of(files[2]);
  if (said.empty()) throw SlurmError(words[0] + " ended with " + describe_exit(*status), false);
  throw SlurmError(said.substr(0, said.find('\n')), is_refusal(said));
}

/// @return nothing for the name of a job that is none of ours
std::optional<SlurmName> name_of(std::string_view text) {
  const std::size_t dot = text.rfind('.');
  if (!text.starts_with(name_prefix) || dot == std::string_view::npos) return std::nullopt;
  const int attempt = std::atoi(std::string(text.substr(dot + 1)).c_str());
  if (attempt <= 0) return std::nullopt;
  return SlurmName{std::string(text.substr(name_prefix.size(), dot - name_prefix.size())), attempt};
}

/// The status of an exit as waitpid() has it, from "18944" or "74:0".
int exit_status_of(const std::string& text) {
  const std::size_t colon = text.find(':');
  const int code = std::atoi(text.c_str());
  return colon == std::string::npos ? code : code << 8 | std::atoi(text.c_str() + colon + 1);
}

/// Of a shell.
std::string in_quotes(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// exec: the worker is the batch shell, which Slurm signals before the time limit.
std::string script_of(const std::string& program, const std::string& folder, int attempt) {
  return "#!/bin/sh\n"
         "export OPENBLAS_NUM_THREADS=1 OMP_NUM_THREADS=1 OMP_THREAD_LIMIT=1\n"
         "exec " +
         in_quotes(program) + " --run " + in_quotes(folder) + " " + std::to_string(attempt) + "\n";
}

}  // namespace

std::string text_of(const SlurmName& name) {
  return std::string(name_prefix) + name.job_id + "." + std::to_string(name.attempt);
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
    const auto known = name_of(name);
    if (!known) continue;
    job.name = *known;
    job.exit_status = exit_status_of(exit_status);
    jobs.emplace(known->job_id, std::move(job));
  }
  return jobs;
}

void slurm_submit(const SlurmName& name, const std::filesystem::path& folder, int cores,
                  const SlurmOptions& options) {
  const auto minutes = [](std::chrono::seconds time) { return (time.count() + 59) / 60; };
  std::vector<std::string> words{
      "sbatch",
      "--parsable",
      "--job-name=" + text_of(name),
      "--comment=dccast job " + name.job_id + ", attempt " + std::to_string(name.attempt),
      "--nodes=1",
      "--ntasks=1",
      "--cpus-per-task=" + std::to_string(cores),
      "--requeue",
      "--signal=B:TERM@" + std::to_string(options.checkpoint_before.count()),
      "--chdir=" + folder.string(),
      "--output=worker.log",
      "--open-mode=append"};
  if (options.time_limit.count() > 0)
    words.push_back("--time=" + std::to_string(minutes(options.time_limit)));
  if (options.memory_bytes > 0.0)
    words.push_back(
        "--mem=" + std::to_string(std::llround(std::ceil(options.memory_bytes / 1048576))) + "M");
  words.insert(words.end(), options.options.begin(), options.options.end());
  run_command(words, script_of(options.worker_program, folder, name.attempt));
}

void slurm_cancel(const SlurmName& name) {
  run_command({"scancel", "--name=" + text_of(name)});
}

void slurm_terminate(const SlurmName& name) {
  run_command({"scancel", "--batch", "--signal=TERM", "--name=" + text_of(name)});
}

}  // namespace dccast::jobs
