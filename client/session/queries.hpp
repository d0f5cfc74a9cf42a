#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "client/model/curl_history.hpp"
#include "client/session/case_faults.hpp"

namespace dccast::client {

/// Answer of a query or result of a job: a case with its curl.
struct Answer {
  std::string name;         ///< name of the file or job, for tables
  std::string job;          ///< id of the job; empty if it is not stored
  bool from_store = false;  ///< no solver ran
  v1::Case description;     ///< complete
  std::vector<v1::CaseChange> changes;
  render::CurlHistory history;
  std::vector<v1::Finding> findings;
  std::optional<v1::ValidityLoss> validity_loss;
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<v1::Failure> failure;
  double solver_s = 0.0;
  double first_point_s = 0.0;  ///< from the call to the first step, measured by the client [s]
  double elapsed_s = 0.0;      ///< from the call to its end [s]
};

/// Calls QueryButtCurl. Throws CommandFailed, Interrupted; the run ends with the call.
/// @param on_response  called with every response as it arrives
/// @return             empty if the case has faults, which are then in `checked`
std::optional<Answer> ask_query(
    Connection& connection, CaseUnderCheck& checked, bool keep,
    const std::function<void(const v1::QueryButtCurlResponse&)>& on_response = {});

/// The same of a job that is there.
Answer answer_of_job(Connection& connection, const std::string& id);

/// Queries several cases, a few at a time: the daemon runs as many as it has cores, and the others
/// wait there. Throws CommandFailed, Interrupted; the runs end with their calls.
/// @return  (case) empty for a case with faults, which are stored in the case
std::vector<std::optional<Answer>> ask_queries(Connection& connection,
                                               std::vector<CaseUnderCheck>& cases);

}  // namespace dccast::client
