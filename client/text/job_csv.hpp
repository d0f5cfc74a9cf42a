#pragma once

#include <string>
#include <vector>

#include "client/model/answer.hpp"
#include "client/session/connection.hpp"

namespace dccast::client {

/// A job with its curl.
struct JobCurl {
  v1::Job job;
  figures::RunHistory history;
  v1::StudyResult study{};  ///< without limits if the job belongs to no refinement study
};

/// Reads a job and its curl, without its study. Throws CommandFailed.
JobCurl curl_of_job(Connection& connection, const std::string& id);

/// Error of mesh and time steps at the steps of the job, from its study, which also has a limit, or
/// else from its quality. Columns are empty where neither is known.
struct CurlError {
  std::vector<double> limit_m;
  std::vector<double> lower_m;  ///< of the limit, if there is one
  std::vector<double> upper_m;
};
CurlError error_of(const JobCurl& curl, const figures::MonitorSeries& series);

/// The curl of every monitor, step by step, in metres and seconds.
std::string curl_csv(const JobCurl& curl);

/// A line for each job: what it is, and how far it has come. Times are those of UTC.
std::string jobs_csv(const std::vector<v1::Job>& jobs);

}  // namespace dccast::client
