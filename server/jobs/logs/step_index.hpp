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

/// A step that a page ended with.
struct StepPlace {
  std::int64_t sequence = 0;  ///< of its event; 0: before the first step
  std::int64_t step = 0;
};

/// A piece of a history: one report per accepted step. Steps that were computed again after a
/// resumption count once, in their last version.
struct StepPage {
  std::vector<v1::StepReport> steps;
  std::optional<StepPlace> next;  ///< where the next page begins; nothing on the last one
};

/// Which events of a log are the steps that count, found in one pass and brought up to date as the
/// log grows, so that a page costs what it holds. Safe to use from several threads.
class StepIndex {
public:
  /// The steps after a place, at least one if there is any.
  /// @param log  the same for every call
  /// @return     nothing when a resumption has taken back the step at that place
  /// @throws std::runtime_error  the log is damaged
  std::optional<StepPage> page(const EventLog& log, const StepPlace& after, std::size_t most_steps,
                               std::size_t most_bytes);

private:
  /// Events from `first` to before `end` whose steps rise from `first_step`; those beyond
  /// `last_step` were taken back.
  struct Span {
    std::int64_t first = 0;
    std::int64_t end = 0;
    std::int64_t first_step = 0;
    std::int64_t last_step = 0;
    bool closed = false;  ///< a step was taken back: later events are not its own
  };

  void bring_up_to_date(const EventLog& log);
  void take_back_from(std::int64_t step);
  void take(std::int64_t sequence, std::int64_t step);
  std::optional<std::vector<Span>> spans_after(const StepPlace& place) const;

  std::mutex mutex_;
  EventLog::Cursor cursor_;
  std::vector<Span> spans_;
};

/// The indexes of the jobs asked for last.
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
