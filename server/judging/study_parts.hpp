#pragma once

#include <string>

#include "server/judging/judged_study.hpp"
#include "server/judging/judgement.hpp"

/// The judgements of the kinds of studies, and what they share.
namespace dccast::judging {

inline constexpr int most_lines = 6;  ///< of a chart, as many as a page has colours

/// Smallest difference worth showing beside a curl [m]: a tenth of a millimetre, of a small curl a
/// hundredth.
double shown_curl_m(double curl_m);

/// Decimals of a length in millimetres, for sentences: 1, below one millimetre 2.
int decimals_of(double metres);
/// A length so: "12.3".
std::string mm(double metres);
/// A share in whole percent, for sentences: "61".
std::string percent(double share);

/// "succeeded", "shell melted through", "beyond validity"
std::string outcome_code(const v1::StudyRun& run);

/// Whether runs of a study are to come: what has no answer may still get one.
bool is_under_way(const v1::StudyResult& result);

/// Runs that the figures do not rest on, each with its values and the reason; nothing where there
/// is none.
void add_lost_runs(const v1::StudyResult& result, v1::JudgementPart::Place place,
                   v1::Judgement& judgement);

/// Every run with its values, its curls at the end and its outcome.
void add_runs(const v1::StudyResult& result, v1::Judgement& judgement);

/// What an answer is conditioned on: the castings of a line.
void add_conditions(const v1::LineExperience& experience, v1::Judgement& judgement);
/// The next casting before and after these.
void add_experience(const v1::LineExperience& experience, v1::Judgement& judgement);

void judge_refinement(const v1::StudyResult& result, v1::Judgement& judgement);
void judge_sweep(const v1::StudyResult& result, v1::Judgement& judgement);
void judge_uncertainty(const StudyToJudge& study, v1::Judgement& judgement);
void judge_sensitivity(const StudyToJudge& study, v1::Judgement& judgement);
void judge_calibration(const v1::StudyResult& result, v1::Judgement& judgement);
void judge_mould(const v1::StudyResult& result, v1::Judgement& judgement);
void judge_remedy(const StudyToJudge& study, v1::Judgement& judgement);
void judge_recipe(const v1::StudyResult& result, v1::Judgement& judgement);

}  // namespace dccast::judging
