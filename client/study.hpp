#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/refinement_study.hpp"
#include "client/render/curl_history.hpp"
#include "dccast/v1/job.pb.h"

namespace dccast::client {

/// One run of a study.
struct StudyLevel {
  int refinement = 1;
  v1::Job job;
  render::CurlHistory history;  ///< whole when the job has succeeded

  bool succeeded() const { return job.state() == v1::SUCCEEDED; }
  bool ends_beyond_validity() const { return !history.beyond.empty() && history.beyond.back(); }
};

/// What a study says of one monitor.
struct MonitorStudy {
  std::string name;
  std::vector<double> end_curl_m;  ///< by level that succeeded, at the end
  CurveLimit limit;                ///< at the instants of the study

  std::size_t least_certain() const;  ///< the instant with the largest uncertainty
};

/// A case run on several meshes, and what its curl tends to.
struct Study {
  std::string id;                  ///< empty: there is none
  std::vector<StudyLevel> levels;  ///< coarsest first, one of each refinement, ended well or not
  std::vector<v1::Job> others;     ///< jobs of the study that are not one of its levels
  std::vector<double> time_s;      ///< instants: the steps of the coarsest level that succeeded
  std::vector<double> cast_length_m;
  /// From here on one of the levels that succeeded is beyond validity, and the limit with it;
  /// nothing when all are valid to their end [s].
  std::optional<double> valid_until_s;
  std::vector<MonitorStudy> monitors;  ///< empty with fewer than two levels that succeeded

  std::vector<const StudyLevel*> succeeded() const;
  bool valid_at(double instant_s) const { return !valid_until_s || instant_s < *valid_until_s; }
  const MonitorStudy* monitor(const std::string& name) const;  ///< null: not in the study
};

/// Orders the runs of one case and extrapolates their curves. Of two runs with one refinement the
/// one that succeeded counts, of two such the newer one.
Study study_of(std::string id, std::vector<StudyLevel> runs);

}  // namespace dccast::client
