#pragma once

#include <optional>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"
#include "proto/frames/steady_face.hpp"

namespace dccast::client {

class Connection;

/// The mould of one run and the cold slab that came out of it.
struct CastMould {
  v1::Section section;
  frames::SteadyFace face;
};

/// One run of a mould design.
struct MouldRun {
  std::string job;  ///< empty while it is not queued
  v1::JobState state = v1::JOB_STATE_UNSPECIFIED;
  std::optional<CastMould> cast;  ///< where it succeeded
  std::string trouble;            ///< why it failed, or why nothing can be read from it
};

/// A study that looks for the opening of a mould, with what each of its runs gave.
struct MouldDesign {
  v1::StudyResult result;
  double wanted_m = 0.0;  ///< half-thickness of the cold slab
  std::vector<MouldRun> runs;

  const v1::StudyResult::MouldFound& found() const { return result.mould(); }
  /// The run whose opening was found; null while there is none.
  const MouldRun* best() const;
};

/// Throws CommandFailed, also for a study of another kind.
MouldDesign read_mould_design(Connection& connection, const std::string& study);

}  // namespace dccast::client
