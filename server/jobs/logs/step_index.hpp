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

/// Places of the valid steps in an event log. Built in one pass and updated as the log grows, so
/// that reading some steps costs as much as these. Safe to use from several threads.
class StepIndex {
public:
  /// The steps after a given one, at least one if there is any.
  /// @param log  the same for every call
  /// @return     nothing if a resumption has taken back the step `after`
  /// @throws std::runtime_error  the log is damaged
  std::optional<StepPage> page(const EventLog& log, const StepPlace& after, std::size_t most_steps,
                               std::size_t most_bytes);

  /// Steps that are spread evenly over the history from its first one, and its last one.
  /// @param log   as for page()
  /// @param most  at least 2
  /// @throws std::runtime_error  the log is damaged
  std::vector<v1::StepReport> samples(const EventLog& log, std::size_t most);

private:
  struct Entry {
    EventLog::Cursor at;
    std::int64_t step = 0;
  };

  /// Reads the events that were appended since the last call.
  void update(const EventLog& log);
  /// After a resumption: steps from this one on are reported again.
  void take_back_from(std::int64_t step);

  std::mutex mutex_;
  EventLog::Cursor cursor_;
  std::vector<Entry> steps_;  ///< in the order of both
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
