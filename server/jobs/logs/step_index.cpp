#include "server/jobs/logs/step_index.hpp"

#include <algorithm>

namespace dccast::jobs {

std::optional<StepPage> StepIndex::page(const EventLog& log, const StepPlace& after,
                                        std::size_t most_steps, std::size_t most_bytes) {
  constexpr std::size_t entry_overhead = 6;  // tag and length of an entry of a repeated field

  std::optional<std::vector<Span>> spans;
  {
    const std::lock_guard lock(mutex_);
    update(log);
    spans = spans_after(after);
  }
  if (!spans) return std::nullopt;

  StepPage page;
  StepPlace last = after;
  std::size_t bytes = 0;
  for (const Span& span : *spans) {
    EventLog::Cursor cursor{span.first, 0};
    while (cursor.sequence < span.end) {
      const std::int64_t sequence = cursor.sequence;
      auto event = log.read(cursor);
      if (!event) break;
      if (!event->has_step()) continue;
      if (event->step().step() > span.last_step) break;

      bytes += event->step().ByteSizeLong() + entry_overhead;
      const bool full = page.steps.size() >= most_steps || bytes > most_bytes;
      if (full && !page.steps.empty()) {
        page.next = last;
        return page;
      }

      last = {sequence, event->step().step()};
      page.steps.push_back(std::move(*event->mutable_step()));
    }
  }
  return page;
}

void StepIndex::update(const EventLog& log) {
  for (;;) {
    const std::int64_t sequence = cursor_.sequence;
    const auto event = log.read(cursor_);
    if (!event) return;
    if (event->has_resumed()) take_back_from(event->resumed().step() + 1);
    if (event->has_step()) add(sequence, event->step().step());
  }
}

void StepIndex::take_back_from(std::int64_t step) {
  while (!spans_.empty() && spans_.back().first_step >= step) spans_.pop_back();
  if (spans_.empty() || spans_.back().last_step < step) return;
  spans_.back().last_step = step - 1;
  spans_.back().closed = true;
}

void StepIndex::add(std::int64_t sequence, std::int64_t step) {
  take_back_from(step);

  if (spans_.empty() || spans_.back().closed)
    spans_.push_back({sequence, sequence, step, step, false});

  spans_.back().end = sequence + 1;
  spans_.back().last_step = step;
}

std::optional<std::vector<StepIndex::Span>> StepIndex::spans_after(const StepPlace& place) const {
  if (place.sequence == 0) return spans_;

  const auto holds = [&place](const Span& span) {
    return span.first <= place.sequence && place.sequence < span.end &&
           place.step <= span.last_step;
  };
  const auto span = std::ranges::find_if(spans_, holds);
  if (span == spans_.end()) return std::nullopt;

  std::vector<Span> rest(span, spans_.end());
  rest.front().first = place.sequence + 1;
  return rest;
}

}  // namespace dccast::jobs
