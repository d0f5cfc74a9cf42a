#include "client/session/queries.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <mutex>

#include "client/session/jobs.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// The last finding of a code holds.
void take(const v1::Finding& finding, std::vector<v1::Finding>& findings) {
  const auto known = std::ranges::find(findings, finding.code(), &v1::Finding::code);
  if (known == findings.end())
    findings.push_back(finding);
  else
    *known = finding;
}

void take(const v1::QueryButtCurlResponse& response, Clock::time_point begin, Answer& answer) {
  if (response.has_accepted()) {
    answer.from_store = response.accepted().from_store();
    answer.job = response.accepted().job();
    answer.key = response.accepted().answer();
    answer.description = response.accepted().case_();
  } else if (response.has_step()) {
    // The time to the first point is what a user feels as the latency.
    if (answer.history.steps.empty()) answer.first_point_s = seconds_since(begin);
    answer.history.add(response.step());
  } else if (response.has_finding()) {
    take(response.finding(), answer.findings);
  } else if (response.has_validity_lost()) {
    answer.validity_loss = response.validity_lost();
    answer.history.mark_beyond(response.validity_lost().time_s());
  } else if (response.has_ended()) {
    answer.state = response.ended().state();
    answer.solver_s = response.ended().solver_s();
    if (response.ended().has_failure()) answer.failure = response.ended().failure();
  }
}

constexpr std::size_t at_once = 8;
constexpr std::chrono::milliseconds look{20};  // interval between checks for an interruption

using OnWait = std::function<void(const v1::QueryButtCurlResponse::Waiting&)>;

/// One query in a thread with its own interruption.
class Question {
public:
  Question(const Connection& command, CaseUnderCheck& checked, const QueryMode& mode,
           OnWait on_wait)
      : answer_(std::async(std::launch::async, [&command, own = own_, &checked, mode, on_wait] {
          Connection connection = command.another(own);
          return ask_query(connection, checked, mode, [&](const auto& response) {
            if (response.has_waiting()) on_wait(response.waiting());
          });
        })) {}
  Question(Question&&) = default;
  ~Question() {
    if (answer_.valid()) own_->come();  // another query has failed: this answer is no longer needed
  }

  /// Rethrows the exception of the query.
  std::optional<Answer> answer(const Interruption& command) {
    while (answer_.wait_for(look) != std::future_status::ready)
      if (command.came()) own_->come();
    return answer_.get();
  }

private:
  std::shared_ptr<Interruption> own_ = std::make_shared<Interruption>();
  std::future<std::optional<Answer>> answer_;
};

}  // namespace

std::optional<Answer> ask_query(
    Connection& connection, CaseUnderCheck& checked, const QueryMode& mode,
    const std::function<void(const v1::QueryButtCurlResponse&)>& on_response) {
  v1::QueryButtCurlRequest request;
  put_case(checked, connection, request);
  request.set_keep(mode.keep);
  request.set_one_of_several(mode.one_of_several);

  // An interruption cancels the call, and with it the run on the server.
  grpc::ClientContext context;
  const Interruption::Call call(connection.interruption(), context);
  const auto begin = Clock::now();
  const auto reader = connection.stub().QueryButtCurl(&context, request);

  Answer answer;
  answer.changes = checked.changes;
  v1::QueryButtCurlResponse response;
  while (reader->Read(&response)) {
    take(response, begin, answer);
    if (on_response) on_response(response);
  }
  const grpc::Status status = reader->Finish();
  answer.elapsed_s = seconds_since(begin);

  if (connection.interruption().came()) throw Interrupted("the run has ended with it");
  checked.faults = faults_of(status);
  if (!checked.faults.empty()) return std::nullopt;
  check(status, connection.server());

  // The stream can end properly without an end of the run, where the server is shutting down.
  if (answer.state == v1::JOB_STATE_UNSPECIFIED)
    throw CommandFailed(ExitCode::unreachable,
                        connection.server() + " ended the answer before its end; ask again");
  return answer;
}

v1::ComparedRun compared_run(const Answer& answer) {
  constexpr std::size_t longest_name = 100;  // a path may be longer than a request permits
  v1::ComparedRun run;
  if (answer.job.empty())
    run.set_answer(answer.key);
  else
    run.set_job(answer.job);
  run.set_name(values::shortened(values::escaped(answer.name), longest_name));
  return run;
}

v1::ComparedRun run_of_job(const std::string& job) {
  v1::ComparedRun run;
  run.set_job(job);
  return run;
}

v1::Judgement judge_run(Connection& connection, const v1::ComparedRun& run, JudgedParts parts,
                        const std::string& line) {
  v1::CompareRunsRequest request;
  request.set_with_frame(parts == JudgedParts::with_frame);
  request.set_line(line);
  *request.add_runs() = run;
  return connection.call(&Stub::CompareRuns, request).judgement();
}

std::vector<std::optional<Answer>> ask_queries(
    Connection& connection, std::vector<CaseUnderCheck>& cases,
    const std::function<void(std::size_t index, const v1::QueryButtCurlResponse::Waiting&)>&
        on_wait) {
  std::mutex mutex;  // of `on_wait`
  const QueryMode mode{.one_of_several = cases.size() > 1};

  std::vector<std::optional<Answer>> answers;
  while (answers.size() < cases.size()) {
    std::vector<Question> questions;
    const std::size_t end = std::min(cases.size(), answers.size() + at_once);
    for (std::size_t i = answers.size(); i < end; ++i)
      questions.emplace_back(connection, cases[i], mode, [&, i](const auto& waiting) {
        const std::lock_guard lock(mutex);
        on_wait(i, waiting);
      });

    for (Question& question : questions)
      answers.push_back(question.answer(connection.interruption()));
  }
  return answers;
}

std::vector<int> evenly_chosen(int stored, int most) {
  std::vector<int> numbers;
  const int count = std::min(stored, most);
  for (int i = 0; i + 1 < count; ++i)
    numbers.push_back(1 + static_cast<int>(std::lround(double(i) * (stored - 1) / (count - 1))));
  if (count > 0) numbers.push_back(stored);
  return numbers;
}

FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most) {
  FrameSeries series{.stored = last.frame_time_s_size(), .frames = {}, .fields = {}};
  v1::QueryResultRequest request;
  request.set_id(id);
  request.set_frame(true);
  request.set_drawing(true);
  request.set_page_size(1);
  // The last frame came with the answer that named their number.
  for (const int number : evenly_chosen(series.stored, most)) {
    request.set_frame_number(number);
    series.frames.push_back(number == series.stored
                                ? last.frame()
                                : connection.call(&Stub::QueryResult, request).frame());
  }

  request.set_frame_number(series.stored);
  for (const v1::FrameField& field : last.frame().fields()) {
    request.set_field(field.name());
    series.fields.push_back(connection.call(&Stub::QueryResult, request).frame().field());
  }
  return series;
}

}  // namespace dccast::client
