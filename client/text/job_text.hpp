#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/text/terminal.hpp"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// "running", "succeeded", ...
std::string state_text(v1::JobState state);

/// The judged curl of the last step; null where there is none, or the run failed or lost its
/// validity.
const v1::MonitorValue* sound_curl(const v1::Job& job);
/// The curl so far that is judged [mm]; "-" for none.
std::string judged_curl_text(const v1::Job& job);

/// Local time of a time stamp, "2024-05-01 13:45:10"; "-" for none.
std::string time_text(const google::protobuf::Timestamp& time);

/// "4 min 10 s"; "a moment" if a worker is about to become free.
std::string start_text(double starts_in_s);

/// One line about an event that is not a step.
std::string event_line(const v1::JobEvent& event);

/// "solve failed", "motion too large", "worker hung", ...
std::string failure_kind_text(v1::Finding::Kind kind);

/// Whether a queued job waits for the end of others, or for the time of its beginning.
bool waits_for_others(const v1::Job& job);
bool waits_for_its_time(const v1::Job& job);

/// State with important details: "queued #3, held", "queued, after 0f2b9a4e", "succeeded, beyond
/// validity".
std::string full_state_text(const v1::Job& job);

/// Why a job failed, in a few lines: kind, message, time, step and place, the last residuals, and
/// subsequent failures.
std::string failure_text(const v1::Finding& failure);

/// All details of one job, one per line.
std::string job_sheet(const v1::Job& job);

/// Names of the available columns of a list of jobs.
std::vector<std::string> job_columns();

/// A line of a list: a job, or a study, which stands for its runs or above them.
struct ListLine {
  v1::Job job{};
  std::optional<v1::Study> study{};
  bool below_study = false;  ///< a run, indented below the line of its study
};

/// A table of such lines. On a terminal no line is longer than that; else no text is truncated.
/// @param columns  from job_columns(); empty: the usual ones, plus curl, findings and labels if one
///                 of the jobs has them
std::string job_table(const std::vector<ListLine>& lines, std::vector<std::string> columns,
                      const Terminal& terminal);

}  // namespace dccast::client
