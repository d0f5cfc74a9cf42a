#include "server/jobs/retention.hpp"

#include <condition_variable>
#include <mutex>
#include <utility>

#include "server/jobs/events.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/jobs/log.hpp"

namespace dccast::jobs {

Retention::Retention(RetentionOptions options, JobStore& store, Scheduler& scheduler)
    : options_(std::move(options)),
      store_(store),
      scheduler_(scheduler),
      thread_([this](const std::stop_token& stop) { run(stop); }) {}

void Retention::run(const std::stop_token& stop) {
  std::mutex mutex;
  std::condition_variable_any never;
  std::unique_lock lock(mutex);
  bool measured = false;
  do {
    try {
      if (!std::exchange(measured, true)) measure(stop);
      if (options_.time.count() == 0 && options_.bytes == 0) return;
      if (scheduler_.held().empty()) look();
    } catch (const std::exception& error) {
      log::error("old jobs cannot be looked at now: {}", error.what());
    }
  } while (!never.wait_for(lock, stop, options_.interval, [&] { return stop.stop_requested(); }));
}

/// Rows of an earlier version have the size of the case alone.
void Retention::measure(const std::stop_token& stop) {
  for (const JobStore::Ended& job : store_.ended(true)) {
    if (stop.stop_requested()) return;
    const std::int64_t bytes = bytes_kept(options_.jobs_directory / job.id);
    if (bytes != job.bytes) store_.update_bytes(job.id, bytes);
  }
}

void Retention::look() {
  const auto ended = store_.ended(false);
  const std::int64_t oldest_ms =
      milliseconds(now()) - std::chrono::milliseconds(options_.time).count();
  std::int64_t bytes = 0;
  for (const JobStore::Ended& job : ended) bytes += job.pinned ? 0 : job.bytes;
  for (const JobStore::Ended& job : ended) {
    const bool too_old = options_.time.count() > 0 && job.ended_ms < oldest_ms;
    const bool too_much = options_.bytes > 0 && bytes > options_.bytes;
    if (!too_old && !too_much) return;  // those that follow have ended later
    if (remove(job, too_old ? "keep_time" : "keep_size")) bytes -= job.bytes;
  }
}

bool Retention::remove(const JobStore::Ended& job, const char* why) {
  if (job.pinned || scheduler_.is_awaited(job.id)) return false;
  const auto reply = scheduler_.remove(job.id, why, [](const v1::Job& found) {
    return !found.pinned();  // since it was listed
  });
  return reply.kind == Reply::Kind::done;
}

}  // namespace dccast::jobs
