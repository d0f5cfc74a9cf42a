#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "proto/frames/steady_face.hpp"

namespace dccast::client {

class Connection;

/// The mould of one run and the resulting cold slab.
struct CastMould {
  v1::Section section;
  frames::SteadyFace face;
};

/// One run of a mould design.
struct MouldRun {
  std::string job;  ///< empty until it is queued
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<CastMould> cast;  ///< set if the run succeeded
  std::string reason;             ///< why the run failed or its results cannot be read
};

/// A study that searches for the opening of a mould, with the results of its runs.
struct MouldDesign {
  v1::StudyResult result;
  double wanted_m = 0.0;  ///< wanted half-thickness of the cold slab [m]
  std::vector<MouldRun> runs;

  const v1::StudyResult::MouldFound& found() const { return result.mould(); }
  /// Whether the face of the best run has stopped changing along the slab, within the tolerance: a
  /// face that has not may contract further.
  bool steady() const;
  /// The run with the opening that was found; null if there is none yet.
  const MouldRun* best() const;
};

/// Throws CommandFailed, also for a study of another kind.
MouldDesign read_mould_design(Connection& connection, const std::string& study);

}  // namespace dccast::client
