#include "server/service/line_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "proto/case_file/study_keys.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/refusals.hpp"
#include "server/studies/lines.hpp"

namespace dccast::service {
namespace {

/// Newest studies among which drafts are looked for.
constexpr int most_looked_at = 200;

/// Whether the caller may read what a request of this kind is about.
grpc::Status permit_to_read(Context& context, const Call& call,
                            const google::protobuf::Descriptor& request, const std::string& id) {
  return context.gate.permit_touch(call.caller, access::rule_of(request), id);
}

/// The complete case of a study; empty: it is not there any more, or its case has faults.
std::optional<v1::Case> case_of(Context& context, const std::string& study) {
  v1::CreateStudyRequest known;
  known.mutable_sweep()->set_further_of(study);
  const auto attachments = context.studies.requests().complete(known);
  if (!attachments) return std::nullopt;
  const auto examined = context.intake.complete_case(known.case_(), *attachments);
  if (!examined.verdict.faults().empty()) return std::nullopt;
  return examined.complete;
}

bool is_over_data(const v1::Study& study) {
  return study.sweep().purpose() == v1::SweepPlan::UNCERTAINTY &&
         study.sweep().further_of().empty() && study.succeeded() > 0;
}

[[noreturn]] void refuse_line(const std::string& line, const studies::CannotPredict& reason) {
  refuse(ErrorInfo::WRONG_STATE, "line {} conditions nothing: {}", line, reason.what());
}

/// The case whose recipe a request is about.
v1::Case recipe_of(Context& context, const Call& call, const v1::CreateStudyRequest& request) {
  v1::Case complete;
  if (request.has_recipe())
    return context.intake
        .complete_case(request.case_(), uploaded_files(context, call, request.attachments()))
        .complete;
  const std::string& job = request.remedy().job();
  readable_job(context, call.caller, job);
  if (!jobs::read_complete_case(context.jobs_directory / job, complete))
    refuse(ErrorInfo::DAMAGED, "the case of job {} cannot be read any more", job);
  return complete;
}

}  // namespace

studies::LineAnswer ask_line(Context& context, const Call& call, const v1::StudyResult& drafts,
                             int monitor, const std::string& line, bool assume_sound) {
  v1::Line known;
  if (!line.empty()) {
    check_line_name(line);
    const auto status = permit_to_read(context, call, *v1::GetLineRequest::descriptor(), line);
    if (!status.ok()) throw Refusal{status};
    known = learned_line(context, line);
  }
  const auto base = case_of(context, drafts.study().id());
  if (!base) throw studies::CannotPredict("the case of the study cannot be read any more");
  return studies::ask_line(drafts, {*base, monitor, known, assume_sound});
}

v1::StudyResult drafts_over_data(Context& context, const Call& call, const v1::Case& complete) {
  const std::string recipe = studies::recipe_name(complete);
  for (const v1::Study& study : context.studies.requests().list({.size = most_looked_at})) {
    if (!is_over_data(study) ||
        !permit_to_read(context, call, *v1::GetStudyRequest::descriptor(), study.id()).ok())
      continue;
    const auto base = case_of(context, study.id());
    if (!base || studies::recipe_name(*base) != recipe) continue;
    v1::EvaluateStudyRequest request;
    request.set_id(study.id());
    if (auto found = context.studies.evaluation().evaluate(request)) return std::move(*found);
  }
  throw studies::CannotPredict(
      "no study has drafts over the data of this recipe; dccast uncertainty CASE computes them");
}

std::optional<LineOfPlan> ask_line_of_plan(Context& context, const Call& call,
                                           v1::CreateStudyRequest& request) {
  const bool is_recipe = request.has_recipe();
  if (!is_recipe && !request.has_remedy()) return std::nullopt;
  if (is_recipe) {
    request.mutable_recipe()->clear_experience();
    request.mutable_recipe()->clear_members();
  } else {
    request.mutable_remedy()->clear_experience();
    request.mutable_remedy()->clear_data();
  }
  const std::string line = is_recipe ? request.recipe().line() : request.remedy().line();
  if (line.empty()) return std::nullopt;

  try {
    const v1::StudyResult drafts =
        drafts_over_data(context, call, recipe_of(context, call, request));
    const int monitor = case_file::monitor_of(drafts, is_recipe ? request.recipe().monitor() : "");
    LineOfPlan found{ask_line(context, call, drafts, std::max(0, monitor), line, false),
                     drafts.study().sweep()};
    if (found.answer.castings.size() == 0)
      throw studies::CannotPredict("fewer than 30 draws fit its castings: check its records");
    (is_recipe ? *request.mutable_recipe()->mutable_experience()
               : *request.mutable_remedy()->mutable_experience()) = found.answer.experience;
    return found;
  } catch (const studies::CannotPredict& reason) {
    refuse_line(line, reason);
  }
}

void take_line(const LineOfPlan& line, v1::CreateStudyRequest& request) {
  try {
    if (request.has_recipe())
      return studies::take_members(line.answer, line.sweep, *request.mutable_recipe());
    const auto data = studies::middle_casting(line.answer, line.sweep, request.case_());
    *request.mutable_remedy()->mutable_data() = {data.begin(), data.end()};
  } catch (const studies::CannotPredict& reason) {
    refuse_line(line.answer.experience.line(), reason);
  }
}

}  // namespace dccast::service
