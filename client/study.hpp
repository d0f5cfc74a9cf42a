#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// One run of a refinement study.
struct StudyLevel {
  int refinement = 1;
  v1::Job job;                     ///< without an id while the run is not queued yet
  std::vector<double> end_curl_m;  ///< by monitor of the study; NaN unless it succeeded

  bool succeeded() const { return job.state() == v1::SUCCEEDED; }
  bool ends_beyond_validity() const { return job.has_validity_loss(); }
};

/// What curves on finer and finer meshes say of the curve they tend to.
struct CurveLimit {
  std::optional<double> order;        ///< observed; nothing where the curves do not settle
  std::vector<double> value_m;        ///< extrapolated; the finest curve where there is no order
  std::vector<double> uncertainty_m;  ///< half width of the interval around `value_m`
};

/// What a study says of one monitor.
struct MonitorStudy {
  std::string name;
  std::vector<double> end_curl_m;  ///< by level that succeeded, at the end
  CurveLimit limit;                ///< at the instants of the study

  std::size_t least_certain() const;  ///< the instant with the largest uncertainty
};

/// A case run on several meshes, and what its curl tends to: EvaluateStudy's answer, arranged for
/// tables and charts.
struct Study {
  std::string id;                  ///< empty: there is none
  std::vector<StudyLevel> levels;  ///< coarsest first
  std::vector<v1::Job> others;     ///< jobs of the study that are not one of its levels
  std::vector<std::string> monitor_names;
  std::vector<double> time_s;  ///< instants of the limits
  std::vector<double> cast_length_m;
  /// From here on one of the levels that succeeded is beyond validity, and the limit with it;
  /// nothing when all are valid to their end [s].
  std::optional<double> valid_until_s;
  std::vector<MonitorStudy> monitors;  ///< empty with fewer than two levels that succeeded

  std::vector<const StudyLevel*> succeeded() const;
  bool valid_at(double instant_s) const { return !valid_until_s || instant_s < *valid_until_s; }
  const MonitorStudy* monitor(const std::string& name) const;  ///< null: not in the study
};

/// @param jobs  those of the study, oldest first
Study study_of(const v1::StudyResult& result, const std::vector<v1::Job>& jobs);

}  // namespace dccast::client
