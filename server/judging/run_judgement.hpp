#pragma once

#include <optional>

#include "dccast/v1/judgement.pb.h"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/study.pb.h"
#include "server/judging/followed_casting.hpp"
#include "server/judging/judged_run.hpp"

namespace dccast::judging {

/// A run, and what is known of it beside its case and its steps.
struct RunToJudge {
  JudgedRun run;  ///< with a step at least
  /// The time from which on the model is not valid [s]; empty: the run has not lost its validity.
  std::optional<double> valid_until_s{};
  v1::StudyResult refinement{};  ///< the evaluated refinement study of the run; empty: none
  std::optional<FollowedCasting> followed{};  ///< empty: the run follows no casting
  std::optional<v1::Frame> last_frame{};      ///< the last stored one; empty: it is not judged
};

/// What one run shows: a sentence about the judged curl at the end, its error and the plant's
/// band; a sentence about when it came and where the heat left meanwhile; the tables "curls" and
/// "end" with the figures of the last step; charts of the curl (the first one against time), of
/// speed and water, and of what decides whether a casting succeeds; how much of the curl is
/// discretisation, with the tables of the refinement study; of a followed casting measured against
/// forecast curl; what the last frame shows; recipe,
/// checks and basis of the run. Each chart has a note.
v1::Judgement judge_run(const RunToJudge& run);

/// Charts of speed and water, then of shell, sump, temperatures, heat, wetting and contact against
/// time; those without a figure other than zero are left out. For two steps or more.
void add_histories(const JudgedRun& run, v1::Judgement& judgement);

/// Of a frame: gap and pressure along the bottom of a section; of a quarter slab the table
/// "bottom", and the pull-in of its wide face as chart and table, where the mesh permits it.
/// @param is_beyond  whether the frame was stored after the model had stopped being valid
void add_frame(const v1::Case& solved, const v1::Frame& frame, bool is_beyond,
               v1::Judgement& judgement);

/// Tables of facts, each a name, a value and a remark: what was cast, as a plant reads it; how
/// sound the numbers are, and what they took; what they rest on.
void add_recipe(const v1::Case& input, const std::string& heading, v1::Judgement& judgement);
/// @param is_beyond  whether the last step is no longer valid
void add_checks(const JudgedRun& run, bool is_beyond, v1::Judgement& judgement);
void add_basis(const v1::Case& input, v1::Judgement& judgement);

}  // namespace dccast::judging
