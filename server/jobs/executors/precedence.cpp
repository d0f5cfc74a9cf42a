#include "server/jobs/executors/precedence.hpp"

#include <algorithm>
#include <iterator>

namespace dccast::jobs {

namespace {

// Estimates are up to three times the solving time: 2.8 s for the thickness section as shipped, 9 s
// for a 3D draft, 42 s for the 3D start at the quality of engineering.
constexpr double longest_quick_s = 5.0;
constexpr double longest_draft_s = 30.0;

bool stops_others(Urgency urgency) {
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

Precedence::Registration Precedence::enter(Urgency urgency, double estimated_s,
                                           OnChange on_change) {
  const std::lock_guard lock(mutex_);
  entries_.push_back({urgency, estimated_s, std::move(on_change)});
  const auto entry = std::prev(entries_.end());
  stop_or_continue_all();
  return {*this, entry};
}

void Precedence::remove(Entries::iterator entry) {
  const std::lock_guard lock(mutex_);
  // The worker may be used again, so it must not stay stopped.
  if (entry->stopped) entry->on_change(std::nullopt);
  entries_.erase(entry);
  stop_or_continue_all();
}

void Precedence::stop_or_continue_all() {
  const auto first = std::ranges::min_element(entries_, {}, &Entry::urgency);
  if (first == entries_.end()) return;

  // Of equally urgent runs the first one began first; its remaining time is the one to report.
  const std::chrono::duration<double> ran = std::chrono::steady_clock::now() - first->begin;
  const MoreUrgentRun more_urgent{std::max(0.0, first->estimated_s - ran.count())};

  for (Entry& entry : entries_) {
    const bool stops = stops_others(first->urgency) && entry.urgency > first->urgency;
    if (std::exchange(entry.stopped, stops) == stops) continue;
    entry.on_change(stops ? std::optional(more_urgent) : std::nullopt);
  }
}

}  // namespace dccast::jobs
