#pragma once

#include <string>

#include "dccast/v1/study.pb.h"

/// Results of studies, written down for tests.
namespace dccast::support {

/// Adds an axis with two ends to the plan of a sweep.
inline void add_axis(v1::StudyResult& result, const std::string& key, const std::string& low,
                     const std::string& high) {
  auto& axis = *result.mutable_study()->mutable_sweep()->add_axes();
  axis.set_key(key);
  axis.add_values(low);
  axis.add_values(high);
}

/// Adds a run that moves one axis (-1: none) to its low end (0) or high end (1).
/// @param curl_mm  of the first monitor at the end; the second has 1 mm
inline v1::StudyRun& add_run(v1::StudyResult& result, int axis, int end, double curl_mm) {
  v1::StudyRun& run = *result.add_runs();
  run.set_state(v1::SUCCEEDED);
  const auto& axes = result.study().sweep().axes();
  for (int i = 0; i < axes.size(); ++i) run.add_values(i == axis ? axes[i].values(end) : "");
  run.add_end_curl_m(1e-3 * curl_mm);
  run.add_end_curl_m(1e-3);
  return run;
}

}  // namespace dccast::support
