#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/job.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"
#include "proto/figures/run_history.hpp"

namespace dccast::client {

/// The history of a job as QueryResult has it.
figures::RunHistory run_history(const v1::Job& job, const v1::QueryResultResponse& result);

/// Answer of a query or result of a job: a case with its curl.
struct Answer {
  std::string name;         ///< name of the file or job, for tables
  std::string job;          ///< id of the job; empty if it is not stored
  std::string key;          ///< names the answer to the server where there is no job
  bool from_store = false;  ///< no solver ran
  v1::Case description;     ///< complete
  std::vector<v1::CaseChange> changes;
  /// Curves, findings and end of a run, as far as it has come.
  figures::RunHistory history;
  std::vector<v1::Finding> findings;
  std::optional<v1::Finding> validity_loss;
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<v1::Finding> failure;
  double solver_s = 0.0;
  double first_point_s = 0.0;  ///< from the call to the first step, measured by the client [s]
  double elapsed_s = 0.0;      ///< from the call to its end [s]
};

/// What a curl tends to as cells and time steps go to zero, by a refinement study.
struct CurlLimit {
  std::vector<double> value_m;        ///< (instant) [m]; NaN outside the time of the study
  std::vector<double> uncertainty_m;  ///< (instant) half width of the interval around it [m]
  bool extrapolated = false;          ///< else the value is that of the finest run
};
/// @return empty if the study has no limit of this monitor
std::optional<CurlLimit> limit_at(const std::vector<double>& instants_s,
                                  const v1::StudyResult& study, const std::string& monitor);

/// The changes given by the user as KEY=VALUE, in order.
std::vector<v1::CaseChange> changes_of(const std::vector<std::string>& texts);

/// "schedule.hold = 5 s, mesh.rows = 30"; empty for none.
template <class Changes>
std::string changes_text(const Changes& changes) {
  std::string text;
  for (const v1::CaseChange& change : changes)
    text += (text.empty() ? "" : ", ") + change.key() + " = " + change.value();
  return text;
}

}  // namespace dccast::client
