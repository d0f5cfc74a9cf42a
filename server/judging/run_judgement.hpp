#pragma once

#include <optional>

#include "dccast/v1/judgement.pb.h"
#include "dccast/v1/study.pb.h"
#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// A run, and what is known of it beside its case and its steps.
struct RunToJudge {
  JudgedRun run;  ///< with a step at least
  /// The time from which on the model is not valid [s]; empty: the run has not lost its validity.
  std::optional<double> valid_until_s{};
  v1::StudyResult refinement{};  ///< the evaluated refinement study of the run; empty: none
};

/// What one run shows: a sentence about the largest curl at the end, its error and the plant's
/// band; a sentence about when it came and where the heat left meanwhile; the tables "curls" and
/// "end" with the figures of the last step; charts of the curl (the first one against time), of
/// speed and water, and of what decides whether a casting succeeds; how much of the curl is
/// discretisation, with the tables of the refinement study. The table "notes" explains charts, by
/// their keys.
v1::Judgement judge_run(const RunToJudge& run);

/// Charts of speed and water, then of shell, sump, temperatures, heat, wetting and contact against
/// time; those without a figure other than zero are left out. For two steps or more.
void add_histories(const JudgedRun& run, v1::Judgement& judgement);

/// Explains a chart in the table "notes", which is added where it is missing.
void add_note(const v1::Chart& chart, const std::string& note, v1::Judgement& judgement);

}  // namespace dccast::judging
