#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "server/jobs/logs/event_log.hpp"
#include "server/jobs/recent.hpp"

namespace dccast::jobs {

/// The last step of a page.
struct StepPlace {
  std::int64_t sequence = 0;  ///< of its event; 0: before the first step
  std::int64_t step = 0;
};

/// Part of a history: one report per accepted step. A step that was computed again after a
/// resumption appears once, in its last version.
struct StepPage {
  std::vector<v1::StepReport> steps;
  std::optional<StepPlace> next;  ///< the next page follows this step; nothing on the last page
};

/// Index of the valid steps in an event log. Built in one pass and updated as the log grows, so
/// that the cost of a page depends on its own length only. Safe to use from several threads.
class StepIndex {
public:
  /// The steps after a given one, at least one if there is any.
  /// @param log  the same for every call
  /// @return     nothing if a resumption has taken back the step `after`
  /// @throws std::runtime_error  the log is damaged
  std::optional<StepPage> page(const EventLog& log, const StepPlace& after, std::size_t most_steps,
                               std::size_t most_bytes);

private:
  /// Events from `first` to before `end`, whose steps increase from `first_step`. Steps after
  /// `last_step` were taken back.
  struct Span {
    /// Sequence numbers of the span, the end not included, and its first and last step.
    std::int64_t first = 0;
    std::int64_t end = 0;
    std::int64_t first_step = 0;
    std::int64_t last_step = 0;
    bool closed = false;  ///< a step was taken back: later events belong to another span
  };

  /// Reads the events that were appended since the last call.
  void update(const EventLog& log);
  /// After a resumption: steps from this one on are reported again.
  void take_back_from(std::int64_t step);
  /// Adds a step to the last span, or begins another.
  void add(std::int64_t sequence, std::int64_t step);
  /// Spans that hold the steps after a place; empty if the place is unknown.
  std::optional<std::vector<Span>> spans_after(const StepPlace& place) const;

  std::mutex mutex_;
  EventLog::Cursor cursor_;
  std::vector<Span> spans_;
};

/// The indexes of the most recently requested jobs.
class StepIndexes {
public:
  std::shared_ptr<StepIndex> of(const std::string& job_id) {
    const auto kept = recent_.find(job_id);
    return kept ? kept : recent_.keep(job_id, std::make_shared<StepIndex>());
  }

private:
  Recent<StepIndex> recent_{16};
};

}  // namespace dccast::jobs
