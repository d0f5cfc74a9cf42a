#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/model/curl_history.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// Answer of a query or result of a job: a case with its curl.
struct Answer {
  std::string name;         ///< name of the file or job, for tables
  std::string job;          ///< id of the job; empty if it is not stored
  bool from_store = false;  ///< no solver ran
  v1::Case description;     ///< complete
  std::vector<v1::CaseChange> changes;
  CurlHistory history;
  std::vector<v1::Finding> findings;
  std::optional<v1::ValidityLoss> validity_loss;
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<v1::Failure> failure;
  double solver_s = 0.0;
  double first_point_s = 0.0;  ///< from the call to the first step, measured by the client [s]
  double elapsed_s = 0.0;      ///< from the call to its end [s]
};

/// Uncertainty of the final curl caused by mesh and time steps: half the width of the band of
/// docs/error-bars.md [m]. Empty if no band is known for such a case.
/// @param complete  case with all its defaults
/// @param curl_m    computed curl [m]
std::optional<double> discretisation_error(const v1::Case& complete, double curl_m);

}  // namespace dccast::client
