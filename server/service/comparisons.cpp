// The call that judges runs, one alone or several against the first: runs of jobs, and of queries
// whose answers are kept.
#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "server/jobs/folder/job_folder.hpp"
#include "server/judging/judged_comparison.hpp"
#include "server/judging/run_judgement.hpp"
#include "server/judging/study_parts.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/line_answers.hpp"
#include "server/service/refusals.hpp"
#include "server/service/run_history.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {
namespace {

using judging::JudgedRun;
using Summary = v1::Comparison::RunSummary;

constexpr int most_runs = 100;
constexpr std::size_t length_of_short_id = 8;

struct FoundRun {
  JudgedRun judged;
  Summary summary;
  std::string study;  ///< that of the job; empty: none
};

/// @throws Refusal  also where the caller may not read the job
FoundRun find_job_run(Context& context, const Call& call, const std::string& id) {
  const v1::Job job = readable_job(context, call.caller, id);

  FoundRun run;
  if (!jobs::read_complete_case(context.jobs_directory / id, run.judged.description))
    refuse(ErrorInfo::DAMAGED, "the case of job {} cannot be read any more", id);
  intake::make_printable(run.judged.description);

  run.judged.steps = read_steps(context, id);
  run.study = job.study();
  run.judged.name = id.substr(0, length_of_short_id);
  run.summary.set_job(id);
  run.summary.set_title(job.title());
  run.summary.set_state(job.state());
  run.judged.failed = job.state() == v1::FAILED;
  *run.summary.mutable_changes() = job.changes();
  *run.summary.mutable_findings() = job.findings();
  if (job.has_validity_loss()) *run.summary.mutable_validity_loss() = job.validity_loss();
  if (job.has_failure()) *run.summary.mutable_failure() = job.failure();
  return run;
}

/// Stores the finding; a later finding of the same code replaces the earlier one.
void add_or_replace(const v1::Finding& finding, Summary& summary) {
  for (v1::Finding& known : *summary.mutable_findings())
    if (known.code() == finding.code()) {
      known = finding;
      return;
    }
  *summary.add_findings() = finding;
}

/// @param key  names the answer: the fingerprint of its case
/// @throws Refusal  NOT_FOUND: the answer has been dropped
FoundRun find_answer(Context& context, const std::string& key) {
  const auto kept = context.query_answers.find(key);
  if (!kept)
    refuse(ErrorInfo::NOT_FOUND, Remedy{"ask the query again, or keep its run as a job"},
           "the answer of a query is not kept any more");

  FoundRun run;
  run.judged.description.ParseFromString(kept->complete_case);
  run.judged.name = "query";
  run.summary.set_title(run.judged.description.title());

  // The answer is kept as the stream that was sent: collect what a job would have in its record.
  for (const std::string& bytes : kept->messages) {
    v1::QueryButtCurlResponse message;
    message.ParseFromString(bytes);
    if (message.has_step()) {
      run.judged.steps.push_back(std::move(*message.mutable_step()));
    } else if (message.has_finding()) {
      add_or_replace(message.finding(), run.summary);
    } else if (message.has_validity_lost()) {
      *run.summary.mutable_validity_loss() = message.validity_lost();
    } else if (message.has_ended()) {
      run.summary.set_state(message.ended().state());
      run.judged.failed = message.ended().state() == v1::FAILED;
      if (message.ended().has_failure()) *run.summary.mutable_failure() = message.ended().failure();
    }
  }
  return run;
}

FoundRun find_run(Context& context, const Call& call, const v1::ComparedRun& asked) {
  check_text("name", asked.name());
  if (asked.run_case() == v1::ComparedRun::RUN_NOT_SET)
    refuse("a run to be compared names neither a job nor an answer");

  FoundRun run = asked.has_job() ? find_job_run(context, call, asked.job())
                                 : find_answer(context, asked.answer());
  if (!asked.name().empty()) run.judged.name = asked.name();
  run.summary.set_name(run.judged.name);

  if (run.judged.steps.empty())
    refuse(ErrorInfo::WRONG_STATE, Remedy{"ask when it has begun"}, "{} has no step yet",
           run.judged.name);
  return run;
}

/// The refinement study of a run, evaluated; empty where there is none that the caller may read.
v1::StudyResult refinement_of(Context& context, const Call& call, const std::string& study) {
  if (study.empty()) return {};

  // Jobs can share a study id that no study of the server has, or that of another owner.
  const auto& reading = access::rule_of(*v1::GetStudyRequest::descriptor());
  if (!context.gate.permit_touch(call.caller, reading, study).ok()) return {};
  const auto found = context.studies.requests().find(study);
  if (!found || !found->has_refinement()) return {};

  v1::EvaluateStudyRequest request;
  request.set_id(study);
  return context.studies.evaluation().evaluate(request).value_or(v1::StudyResult{});
}

v1::Judgement judge_alone(Context& context, const Call& call, FoundRun run,
                          const v1::CompareRunsRequest& request) {
  judging::RunToJudge judged{std::move(run.judged)};
  if (request.with_frame() && !run.summary.job().empty()) {
    const auto stored = read_frame(context, call, find_job(context, run.summary.job()), {});
    if (stored.has_frame()) judged.last_frame = stored.frame();
  }
  if (run.summary.has_validity_loss()) judged.valid_until_s = run.summary.validity_loss().time_s();
  judged.refinement = refinement_of(context, call, run.study);
  if (!run.summary.job().empty()) judged.followed = followed_casting(context, run.summary.job());
  v1::Judgement judgement = judging::judge_run(judged);
  if (request.line().empty()) return judgement;

  const v1::Case& complete = judged.run.description;
  try {
    const v1::StudyResult drafts = drafts_over_data(context, call, complete);
    const int monitor = std::max(0, judging::monitor_of(drafts, ""));
    judging::add_experience(
        ask_line(context, call, drafts, monitor, request.line(), false).experience, judgement);
  } catch (const studies::CannotPredict& reason) {
    judgement.add_sentences(
        fmt::format("Nothing is said of line {}: {}.", request.line(), reason.what()));
  }
  return judgement;
}

v1::Judgement judge_together(Context& context, const Call& call, std::vector<FoundRun> found,
                             const v1::CompareRunsRequest& request) {
  std::vector<JudgedRun> runs;
  for (FoundRun& run : found) {
    // Figures beyond validity are compared with nothing; the first step stays.
    const auto& loss = run.summary.validity_loss();
    auto& steps = run.judged.steps;
    while (run.summary.has_validity_loss() && steps.size() > 1 &&
           steps.back().time_s() >= loss.time_s())
      steps.pop_back();
    runs.push_back(std::move(run.judged));
  }

  // Companions only give errors: they do not appear in the answer.
  std::vector<JudgedRun> companions;
  for (const v1::ComparedRun& asked : request.companions())
    companions.push_back(find_run(context, call, asked).judged);

  return judging::judge_comparison(runs, companions);
}

void compare(Context& context, const Call& call, const v1::CompareRunsRequest& request,
             v1::Comparison& comparison) {
  if (request.runs().empty() || request.runs_size() > most_runs ||
      request.companions_size() > most_runs)
    refuse("a comparison takes 1 to {} runs and at most as many companions; there are {} and {}",
           most_runs, request.runs_size(), request.companions_size());

  if (request.runs_size() > 1 && !request.line().empty())
    refuse("a line tells of a run alone, and there are {}", request.runs_size());

  if (request.runs_size() == 1 && !request.companions().empty())
    refuse("companions give the errors of differences, and a run alone has none");

  std::vector<FoundRun> runs;
  for (const v1::ComparedRun& asked : request.runs()) {
    runs.push_back(find_run(context, call, asked));
    *comparison.add_runs() = runs.back().summary;
  }

  *comparison.mutable_judgement() =
      runs.size() == 1 ? judge_alone(context, call, std::move(runs.front()), request)
                       : judge_together(context, call, std::move(runs), request);
  if (const std::size_t size = comparison.ByteSizeLong(); size > answer_bytes)
    refuse(ErrorInfo::ANSWER_TOO_LARGE, Remedy{"compare fewer runs"},
           "the comparison has {} bytes, more than an answer of 4 MiB holds", size);
}

}  // namespace

SimulationService::Unary* SimulationService::CompareRuns(Wire* wire,
                                                         const v1::CompareRunsRequest* request,
                                                         v1::Comparison* response) {
  // A frame is read by a worker, as for a check.
  WorkPool& pool = request->with_frame() ? pools_.checks : pools_.histories;
  return answer(wire, *request, pool,
                [=, this](const Call& call) { compare(context_, call, *request, *response); });
}

}  // namespace dccast::service
