#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

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

/// The one answer of a line: what it is conditioned on, and the castings that it leaves possible.
struct LineAnswer {
  v1::LineExperience experience;  ///< `after` is absent where there are no castings
  /// (casting, axis of the study) data, 0 to 1, all of the same weight; empty: fewer than 30
  /// effective draws
  Eigen::MatrixXd castings;
};

/// Conditions the data of an uncertainty study on the castings of a line (docs/lines.md).
/// @param result  of a Latin hypercube, with its runs
/// @throws CannotPredict  too few runs
LineAnswer ask_line(const v1::StudyResult& result, const ExperienceQuestion& question);

/// Keeps castings of an answer in a plan, whose data are axes of the study with the same ends.
/// @param answer  with castings  @param sweep  of its study  @throws CannotPredict
void take_members(const LineAnswer& answer, const v1::SweepPlan& sweep, v1::RecipePlan& plan);
/// The data of the casting in the middle of those of an answer. @param base  case that they change
std::vector<v1::CaseChange> middle_casting(const LineAnswer& answer, const v1::SweepPlan& sweep,
                                           const v1::Case& base);

}  // namespace dccast::studies
