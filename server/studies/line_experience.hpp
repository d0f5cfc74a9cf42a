#pragma once

#include <string>

#include "dccast/v1/line.pb.h"
#include "dccast/v1/study.pb.h"

namespace dccast::studies {

/// What the next casting of a study's recipe is asked of.
struct ExperienceQuestion {
  const v1::Case& base;       ///< complete case of the study
  int monitor = 0;            ///< index of the monitor whose curl is judged
  const v1::Line& line;       ///< without name: none, to assume sound castings alone
  bool assume_sound = false;  ///< that the recipe is cast daily, and soundly
};

/// Conditions the data of an uncertainty study on the castings of a line (docs/lines.md).
/// @param result  of a Latin hypercube, with its runs
/// @throws CannotPredict  too few runs
v1::LineExperience experience_of(const v1::StudyResult& result, const ExperienceQuestion& question);

}  // namespace dccast::studies
