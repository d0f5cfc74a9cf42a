#include "server/jobs/executors/precedence.hpp"

#include <algorithm>
#include <iterator>

namespace dccast::jobs {

namespace {

// Estimates are up to three times the solving time: 2.8 s for the thickness section as shipped, 9 s
// for a 3D draft, 42 s for the 3D start at the quality of engineering.
constexpr double longest_quick_s = 5.0;
constexpr double longest_draft_s = 30.0;

/// A run that has used less of a processor since the last look waits for something.
constexpr double least_share = 0.1;

bool is_short(Urgency urgency) {
  return urgency == Urgency::quick || urgency == Urgency::draft;
}

}  // namespace

Urgency classify_query(double estimated_s, bool one_of_several) {
  if (estimated_s > longest_draft_s) return Urgency::long_query;
  if (one_of_several) return Urgency::comparison;
  return estimated_s > longest_quick_s ? Urgency::draft : Urgency::quick;
}

int nice_value(Urgency urgency) {
  switch (urgency) {
    case Urgency::quick:
    case Urgency::draft:
      return 0;
    case Urgency::comparison:
    case Urgency::long_query:
      return 10;  // leaves a tenth of a core to a job that shares it
    case Urgency::batch:
      return 19;
  }
  return 19;
}

std::string MoreUrgentRun::description() const {
  return "stopped while a more urgent query runs";
}

void Precedence::Registration::leave() {
  if (auto* const precedence = std::exchange(precedence_, nullptr)) precedence->remove(entry_);
}

bool Precedence::Entry::stops_others() const {
  return is_short(run.urgency) && computes && !precedence_has_ended;
}

void Precedence::Entry::look(Clock::time_point now) {
  const auto elapsed = now - std::exchange(looked, now);
  const auto before_s = std::exchange(last_s, run.processor_s());
  if (stopped) return;

  if (stops_others()) held += elapsed;
  if (last_s && before_s)
    computes = *last_s - *before_s >= least_share * std::chrono::duration<double>(elapsed).count();
  precedence_has_ended = precedence_has_ended || held >= longest_hold ||
                         (run.estimated_s > 0.0 && used_s() >= 2.0 * run.estimated_s);
}

Precedence::Precedence() : watcher_([this](const std::stop_token& stop) { watch(stop); }) {}

Precedence::Registration Precedence::enter(Run run) {
  const std::lock_guard lock(mutex_);
  const auto used_s = run.processor_s();
  entries_.push_back({.run = std::move(run), .begin_s = used_s, .last_s = used_s});
  const auto entry = std::prev(entries_.end());
  stop_or_continue_all();
  changed_.notify_all();
  return {*this, entry};
}

void Precedence::remove(Entries::iterator entry) {
  const std::lock_guard lock(mutex_);
  // The worker may be used again, so it must not stay stopped.
  if (entry->stopped) entry->run.on_change(std::nullopt);
  entries_.erase(entry);
  stop_or_continue_all();
}

void Precedence::stop_or_continue_all() {
  // Of equally urgent runs the first one began first; its remaining time is the one to report.
  const Entry* first = nullptr;
  for (const Entry& entry : entries_)
    if (entry.stops_others() && (first == nullptr || entry.run.urgency < first->run.urgency))
      first = &entry;

  for (Entry& entry : entries_) {
    const bool stops = first != nullptr && entry.run.urgency > first->run.urgency;
    if (std::exchange(entry.stopped, stops) == stops) continue;

    std::optional<MoreUrgentRun> more_urgent;
    if (stops) more_urgent.emplace(std::max(0.0, first->run.estimated_s - first->used_s()));
    entry.run.on_change(more_urgent);
  }
}

void Precedence::watch(const std::stop_token& stop) {
  const auto may_stop_others = [](const Entry& entry) {
    return is_short(entry.run.urgency) && !entry.precedence_has_ended;
  };

  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    changed_.wait(lock, stop, [&] { return std::ranges::any_of(entries_, may_stop_others); });
    changed_.wait_for(lock, stop, between_looks, [] { return false; });

    const auto now = Clock::now();
    for (Entry& entry : entries_)
      if (may_stop_others(entry)) entry.look(now);
    stop_or_continue_all();
  }
}

}  // namespace dccast::jobs
