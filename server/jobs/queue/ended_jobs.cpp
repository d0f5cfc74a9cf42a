#include "server/jobs/queue/ended_jobs.hpp"

#include <fcntl.h>
#include <fmt/core.h>
#include <string.h>

#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"

namespace dccast::jobs {

namespace {

// A hook that hangs loses the jobs beyond this number, instead of filling the memory.
constexpr std::size_t largest_backlog = 10000;

}  // namespace

EndHook::EndHook(std::string program, std::chrono::seconds longest)
    : program_(std::move(program)), longest_(longest) {
  if (!program_.empty()) thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void EndHook::on_transition(const v1::Job& job, v1::JobState from) {
  if (program_.empty() || !is_terminal(job.state()) || is_terminal(from)) return;
  const std::lock_guard lock(mutex_);
  if (ended_.size() >= largest_backlog)
    return log::error("job {}: too many jobs wait for {}; it is not run for this one", job.id(),
                      program_);
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
  const std::string& state = v1::JobState_Name(job.state());
  auto variables = environment(false, {"DCCAST_"});
  variables.insert(
      variables.end(),
      {fmt::format("DCCAST_JOB={}", job.id()), fmt::format("DCCAST_STATE={}", state),
       fmt::format("DCCAST_OWNER={}", job.owner()), fmt::format("DCCAST_TITLE={}", job.title()),
       fmt::format("DCCAST_MAIL={}", job.mail()), fmt::format("DCCAST_STUDY={}", job.study())});

  pid_t process = 0;
  const int error = spawn({program_, job.id(), state}, variables,
                          {nothing.get(), nothing.get(), nothing.get()}, &process);
  if (error != 0)
    return log::error("job {}: cannot run {}: {}", job.id(), program_, ::strerror(error));

  const auto status = wait_for(process, longest_, stop);
  if (!status)
    log::error("job {}: {} was killed after {} s at most", job.id(), program_, longest_.count());
  else if (*status != 0)
    log::warn("job {}: {} ended with {}", job.id(), program_, describe_exit(*status));
}

Retention::Retention(RetentionOptions options, JobStore& store, Scheduler& scheduler)
    : options_(std::move(options)),
      store_(store),
      scheduler_(scheduler),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void Retention::run(const std::stop_token& stop) {
  if (options_.time.count() == 0 && options_.bytes == 0) return;
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  do {
    try {
      if (scheduler_.held().empty()) delete_old_jobs();
    } catch (const std::exception& error) {
      log::error("cannot delete old jobs now, trying again later: {}", error.what());
    }
  } while (!never.wait_for(lock, stop, options_.interval, [&] { return stop.stop_requested(); }));
}

void Retention::delete_old_jobs() {
  const auto ended = store_.ended();
  const std::int64_t oldest_ms =
      milliseconds(now()) - std::chrono::milliseconds(options_.time).count();

  std::int64_t bytes = 0;
  for (const JobStore::Ended& job : ended) bytes += job.pinned ? 0 : job.bytes;

  for (const JobStore::Ended& job : ended) {
    const bool too_old = options_.time.count() > 0 && job.ended_ms < oldest_ms;
    const bool too_much = options_.bytes > 0 && bytes > options_.bytes;
    if (!too_old && !too_much) return;  // those that follow have ended later
    if (job.pinned || scheduler_.is_awaited(job.id)) continue;

    // It may have been pinned since it was listed.
    const auto reply =
        scheduler_.remove(job.id, too_old ? "retention.keep_time" : "retention.keep_size",
                          [](const v1::Job& found) { return !found.pinned(); });
    if (reply.kind == Reply::Kind::done) bytes -= job.bytes;
  }
}

}  // namespace dccast::jobs
