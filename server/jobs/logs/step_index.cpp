#include "server/jobs/logs/step_index.hpp"

#include <algorithm>
#include <utility>

namespace dccast::jobs {

namespace {

v1::StepReport step_at(const EventLog& log, EventLog::Cursor place) {
  return std::move(*log.read(place).value().mutable_step());
}

}  // namespace

std::optional<StepPage> StepIndex::page(const EventLog& log, const StepPlace& after,
                                        std::size_t most_steps, std::size_t most_bytes) {
  constexpr std::size_t entry_overhead = 6;  // tag and length of an entry of a repeated field

  std::vector<Entry> rest;
  {
    const std::lock_guard lock(mutex_);
    update(log);
    auto begin = steps_.begin();
    if (after.sequence != 0) {
      begin = std::ranges::find_if(steps_, [&](const Entry& each) {
        return each.at.sequence == after.sequence && each.step == after.step;
      });
      if (begin == steps_.end()) return std::nullopt;
      ++begin;
    }
    rest.assign(begin, steps_.end());
  }

  StepPage page;
  std::size_t bytes = 0;
  for (const Entry& entry : rest) {
    v1::StepReport step = step_at(log, entry.at);
    bytes += step.ByteSizeLong() + entry_overhead;
    const bool full = page.steps.size() >= most_steps || bytes > most_bytes;
    if (full && !page.steps.empty()) {
      const Entry& last = *(&entry - 1);
      page.next = {last.at.sequence, last.step};
      return page;
    }
    page.steps.push_back(std::move(step));
  }
  return page;
}

std::vector<v1::StepReport> StepIndex::samples(const EventLog& log, std::size_t most) {
  std::vector<Entry> spread;
  {
    const std::lock_guard lock(mutex_);
    update(log);
    if (steps_.empty()) return {};

    std::size_t stride = 1;
    while ((steps_.size() - 1) / stride >= most) stride *= 2;
    for (std::size_t i = 0; i < steps_.size(); i += stride) spread.push_back(steps_[i]);
    if (spread.back().step != steps_.back().step) {
      if (spread.size() == most) spread.pop_back();
      spread.push_back(steps_.back());
    }
  }

  std::vector<v1::StepReport> steps;
  for (const Entry& entry : spread) steps.push_back(step_at(log, entry.at));
  return steps;
}

void StepIndex::update(const EventLog& log) {
  for (;;) {
    const EventLog::Cursor place = cursor_;
    const auto event = log.read(cursor_);
    if (!event) return;
    if (event->has_resumed()) take_back_from(event->resumed().step() + 1);
    if (!event->has_step()) continue;
    take_back_from(event->step().step());
    steps_.push_back({place, event->step().step()});
  }
}

void StepIndex::take_back_from(std::int64_t step) {
  while (!steps_.empty() && steps_.back().step >= step) steps_.pop_back();
}

}  // namespace dccast::jobs
