#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "proto/case_file/study_keys.hpp"

namespace dccast::client {

/// One run of a refinement study.
struct StudyLevel {
  int refinement = 1;
  v1::Job job;                     ///< without an id until the run is queued
  std::vector<double> end_curl_m;  ///< (monitor of the study) [m]; NaN unless the run succeeded

  bool succeeded() const { return job.state() == v1::SUCCEEDED; }
  bool ends_beyond_validity() const { return job.has_validity_loss(); }
};

/// The extrapolated limit of curves on successively refined meshes.
struct CurveLimit {
  std::optional<double> order;  ///< observed order of convergence [1]; empty if not converging
  std::vector<double> value_m;  ///< extrapolated [m]; the finest curve if there is no order
  std::vector<double> uncertainty_m;  ///< half width of the interval around `value_m` [m]
};

/// Result of a study for one monitor.
struct MonitorStudy {
  std::string name;
  std::vector<double> end_curl_m;     ///< (level that succeeded) at the end [m]
  CurveLimit limit;                   ///< at the times of the study
  std::size_t least_certain() const;  ///< index of the time with the largest uncertainty
};

/// A case run on several meshes, and the limit of its curl: the response of EvaluateStudy, arranged
/// for tables and charts.
struct Study {
  std::string id;                  ///< empty: there is no study
  std::vector<StudyLevel> levels;  ///< coarsest first
  std::vector<v1::Job> others;     ///< jobs of the study that are not one of its levels
  std::vector<std::string> monitor_names;
  std::vector<double> time_s;  ///< times of the limits [s]
  std::vector<double> cast_length_m;
  /// Time from which one of the levels that succeeded, and so the limit, is beyond validity [s];
  /// empty if all are valid to their end.
  std::optional<double> valid_until_s;
  std::vector<MonitorStudy> monitors;  ///< empty with fewer than two levels that succeeded

  std::vector<const StudyLevel*> succeeded() const;
  bool valid_at(double instant_s) const { return !valid_until_s || instant_s < *valid_until_s; }
  const MonitorStudy* monitor(const std::string& name) const;  ///< null: not in the study
};

/// @param jobs  jobs of the study, oldest first
Study study_of(const v1::StudyResult& result, const std::vector<v1::Job>& jobs);

using case_file::leading_number, case_file::monitor_of, case_file::range_of;

/// A number with its unit in four digits: "231.5 degC". @param text  as in a case file
std::string rounded(const std::string& text);

/// How the runs of a study ended, "61 valid, 2 beyond validity, 1 failed".
struct RunCount {
  int valid = 0, beyond = 0, failed = 0, open = 0;
  std::string text() const;
};
RunCount count_runs(const v1::StudyResult& result);

}  // namespace dccast::client
