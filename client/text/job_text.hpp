#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::client::render {

/// "running", "succeeded", ...
std::string state_text(v1::JobState state);

/// The curl so far, of the monitor with the largest one [mm]; "-" for none.
std::string largest_curl_text(const v1::Job& job);

/// Local time of a time stamp, "2024-05-01 13:45:10"; "-" for none.
std::string time_text(const google::protobuf::Timestamp& time);

/// One line about an event that is not a step.
std::string event_line(const v1::JobEvent& event);

/// "solve failed", "motion too large", "worker hung", ...
std::string failure_kind_text(v1::Finding::Kind kind);

/// State with important details: "queued #3, held", "succeeded, beyond validity".
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

/// A table of such lines; no text is truncated.
/// @param columns  from job_columns(); empty: the usual ones, plus curl, findings and labels if one
///                 of the jobs has them
std::string job_table(const std::vector<ListLine>& lines, std::vector<std::string> columns);

/// What `dccast top` shows at one moment.
struct TopView {
  /// Address of the server, and its report of itself and of its jobs.
  std::string server;
  v1::GetServerInfoResponse about{};
  std::vector<v1::Job> running{};
  std::vector<v1::Job> queued{};  ///< newest first; may be some of many
};

/// A page of at most so many columns and lines, each ended; with what does not fit left out.
/// @param lines    0: as many as there are
/// @param now_unix [s since 1970]
std::string top_page(const TopView& view, int columns, int lines, std::int64_t now_unix);

}  // namespace dccast::client::render
