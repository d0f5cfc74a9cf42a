#include "client/session/studies.hpp"

#include <algorithm>
#include <iostream>
#include <limits>
#include <utility>

#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/jobs.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

/// Faults of a plan or of one of its cases, one for each line.
void print_refusal(const v1::ValidateCaseResponse& verdict, const CaseUnderCheck& checked) {
  const std::string run = verdict.run().empty() ? "" : verdict.run() + ": ";
  for (const v1::Fault& fault : verdict.faults())
    std::cerr << run << describe(fault, checked.read.source) << '\n';
}

/// Reads one stream until it ends.
struct Stream {
  std::optional<v1::Study> last;
  grpc::Status status;
};

Stream read_stream(Connection& connection, const std::string& id,
                   const std::function<void(const v1::Study&)>& on_study) {
  v1::WatchStudyRequest request;
  request.set_id(id);
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  // Each message is the whole study, so a stream that is taken up again misses nothing.
  const auto reader = connection.stub().WatchStudy(&context, request);
  Stream stream;
  v1::Study study;
  while (reader->Read(&study)) {
    on_study(study);
    stream.last = study;
  }
  stream.status = reader->Finish();
  return stream;
}

std::string newest_study(Connection& connection) {
  v1::ListStudiesRequest request;
  request.set_owner(user_name(connection));
  const auto newest = list_studies(connection, request, 1);
  if (!newest.empty()) return newest.front().id();
  throw CommandFailed(ExitCode::not_found, "'last': no study on " + connection.server() +
                                               " belongs to " + request.owner() +
                                               " (dccast studies)");
}

std::string study_that_begins(Connection& connection, const std::string& prefix) {
  v1::ListStudiesRequest request;
  request.set_id_prefix(prefix);
  const auto found = list_studies(connection, request, 2);
  if (found.empty())
    throw CommandFailed(ExitCode::not_found, "no study on " + connection.server() +
                                                 " begins with '" + prefix + "' (dccast studies)");
  if (found.size() > 1)
    throw invalid("'" + prefix + "' is the beginning of more than one study:\n  " + found[0].id() +
                  "\n  " + found[1].id());
  return found.front().id();
}

}  // namespace

std::optional<v1::Study> create_study(
    Connection& connection, const StudyCase& base,
    const std::function<void(v1::CreateStudyRequest&)>& add_plan) {
  CaseUnderCheck checked = read_case(base.file, changes_of(base.set));
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    return std::nullopt;
  }

  v1::CreateStudyRequest request;
  request.set_request_id(values::random_uuid());
  put_case(checked, connection, request);
  *request.mutable_labels() = {base.labels.begin(), base.labels.end()};
  add_plan(request);

  v1::Study study;
  const grpc::Status status = connection.try_call(&Stub::CreateStudy, request, study);
  const v1::ValidateCaseResponse verdict = verdict_of(status);
  if (!verdict.faults().empty()) {
    // The faulty values belong to the plan, not to the case.
    if (!base.plan_origin.empty())
      for (const auto& axis : request.sweep().axes())
        checked.read.source.set(axis.key(), {}, base.plan_origin + " " + axis.key());
    print_refusal(verdict, checked);
    return std::nullopt;
  }

  check(status, connection.server());
  return study;
}

v1::Study follow_study(Connection& connection, const std::string& id,
                       const std::function<void(const v1::Study&)>& on_study,
                       std::ostream& messages, const RetryPolicy& policy) {
  auto pause = policy.first_pause;
  for (int attempt = 0; attempt < policy.attempts;) {
    const Stream stream = read_stream(connection, id, on_study);
    if (stream.status.ok() && stream.last && stream.last->state() != v1::STUDY_RUNNING)
      return *stream.last;
    if (connection.interruption().came()) throw Interrupted("");
    if (!is_passing(stream.status.error_code()))
      throw failure_of(stream.status, connection.server());

    // A stream that brought a state is sound: attempts count those in a row that brought none.
    attempt = stream.last ? 1 : attempt + 1;
    if (stream.last) pause = policy.first_pause;
    if (attempt == policy.attempts) break;

    messages << "watch: the stream from " << connection.server()
             << " ended but the study has not; taking it up again (attempt " << attempt << " of "
             << policy.attempts - 1 << ")" << std::endl;
    connection.interruption().sleep(pause);
    pause = std::min(2 * pause, policy.longest_pause);
  }
  throw CommandFailed(ExitCode::unreachable, "lost the stream of study " + id + " from " +
                                                 connection.server() +
                                                 "; the study itself goes on");
}

void read_studies(Connection& connection, v1::ListStudiesRequest request,
                  const std::function<bool(const v1::Study&)>& take) {
  do {
    const auto page = connection.call(&Stub::ListStudies, request);
    for (const v1::Study& study : page.studies())
      if (!take(study)) return;
    request.set_page_token(page.next_page_token());
  } while (!request.page_token().empty());
}

std::vector<v1::Study> list_studies(Connection& connection, v1::ListStudiesRequest request,
                                    int limit) {
  constexpr int largest_page = 1000;  // service.proto
  request.set_page_size(std::min(largest_page, limit));

  std::vector<v1::Study> studies;
  read_studies(connection, std::move(request), [&](const v1::Study& study) {
    studies.push_back(study);
    return static_cast<int>(studies.size()) < limit;
  });
  return studies;
}

std::string resolve_study(Connection& connection, const std::string& text) {
  if (text != "last" && !can_begin_an_id(text)) return text;
  return text == "last" ? newest_study(connection) : study_that_begins(connection, text);
}

ExitCode exit_code_of(const v1::StudyJudgement& answer, bool has_answer) {
  // A study under way is no failure of the command.
  if (answer.study().state() == v1::STUDY_RUNNING || has_answer) return ExitCode::done;
  return ExitCode::solve_failed;
}

std::vector<v1::Job> jobs_of_study(Connection& connection, const std::string& id) {
  v1::ListJobsRequest request;
  request.set_study(id);
  std::vector<v1::Job> jobs =
      list_jobs(connection, std::move(request), std::numeric_limits<int>::max()).jobs;
  std::reverse(jobs.begin(), jobs.end());
  return jobs;
}

v1::StudyResult evaluate_study(Connection& connection, const std::string& id) {
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  return connection.call(&Stub::EvaluateStudy, request);
}

v1::StudyJudgement judge_study(Connection& connection, const StudyQuestion& question) {
  v1::JudgeStudyRequest request;
  request.set_id(question.id);
  request.set_monitor(question.monitor);
  request.set_with_result(true);
  request.set_with_curves(question.curves);
  request.set_line(question.line);
  request.set_assume_sound(question.assume_sound);
  return connection.call(&Stub::JudgeStudy, request);
}

std::string found_case(Connection& connection, v1::JudgeStudyRequest question,
                       const StudyCase& base) {
  const CaseUnderCheck checked = read_case(base.file, changes_of(base.set));
  if (!checked.faults.empty()) {
    print_faults(checked, std::cerr);
    throw invalid(base.file + " has faults");
  }
  *question.mutable_case_() = checked.description;
  return connection.call(&Stub::JudgeStudy, question).case_file();
}

v1::StudyResult find_study(Connection& connection, const std::string& id) {
  v1::EvaluateStudyRequest request;
  request.set_id(id);
  v1::StudyResult result;
  const grpc::Status status = connection.try_call(&Stub::EvaluateStudy, request, result);
  if (status.error_code() == grpc::StatusCode::NOT_FOUND) return {};
  check(status, connection.server());
  return result;
}

v1::StudyResult refinement_of(Connection& connection, const v1::Job& job) {
  if (job.study().empty()) return {};

  // Jobs can share a study id that no study of the server has.
  v1::StudyResult result = find_study(connection, job.study());
  return result.study().has_refinement() ? result : v1::StudyResult();
}

}  // namespace dccast::client
