#pragma once

#include <optional>
#include <string>

#include "server/service/gate.hpp"
#include "server/service/simulation_service.hpp"
#include "server/studies/line_experience.hpp"

namespace dccast::service {

/// What a line says by the drafts of an uncertainty study. @param line  empty: no line, to assume
/// sound castings alone
/// @throws Refusal  there is no such line, or the caller may not read it
/// @throws studies::CannotPredict
studies::LineAnswer ask_line(Context& context, const Call& call, const v1::StudyResult& drafts,
                             int monitor, const std::string& line, bool assume_sound);

/// The newest study of `dccast uncertainty` over the data of a recipe that the caller may read,
/// evaluated. @param complete  a case of the recipe @throws studies::CannotPredict  there is none
v1::StudyResult drafts_over_data(Context& context, const Call& call, const v1::Case& complete);

/// What the line of a plan says.
struct LineOfPlan {
  studies::LineAnswer answer;  ///< with castings
  v1::SweepPlan sweep;         ///< whose axes these have
};

/// Writes into a plan of a recipe or a remedy that names a line what it is conditioned on. The same
/// castings give the same text. @return  empty: it names none
/// @throws Refusal  nothing can be said of the line
std::optional<LineOfPlan> ask_line_of_plan(Context& context, const Call& call,
                                           v1::CreateStudyRequest& request);
/// Writes the data into a request that has its case and data. @throws Refusal
void take_line(const LineOfPlan& line, v1::CreateStudyRequest& request);

}  // namespace dccast::service
