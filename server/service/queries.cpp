// The call of near-real-time queries: answered by a run of its own, or by one that was there.
#include <chrono>
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "dccast/v1/worker.pb.h"
#include "proto/case_file/quality.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/log.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

namespace {

using v1::RunEnd;
using Response = v1::QueryButtCurlResponse;
using Responses = std::vector<Response>;

using SendQueryResponse = std::function<void(Response)>;

constexpr double longest_query_s = 24 * 3600.0;
constexpr std::size_t most_steps_at_once = 1000;
constexpr std::size_t most_bytes_at_once = 1'000'000;

Response accepted(const intake::ExaminedCase& examined, bool from_store, const std::string& job) {
  Response response;
  response.mutable_accepted()->set_from_store(from_store);
  response.mutable_accepted()->set_job(job);
  *response.mutable_accepted()->mutable_case_() = examined.complete;
  if (const auto error = case_file::relative_discretisation_error(examined.complete))
    response.mutable_accepted()->set_relative_curl_error(*error);
  return response;
}

v1::JobState state_of(RunEnd::Outcome outcome) {
  if (outcome == RunEnd::SUCCEEDED) return v1::SUCCEEDED;
  return outcome == RunEnd::FAILED ? v1::FAILED : v1::CANCELLED;
}

/// Steps, findings and the end of a job that has succeeded; nothing if its history cannot be read.
std::optional<Responses> answer_of_job(Context& context, const v1::Job& job) {
  Responses answer;
  try {
    const auto log = context.scheduler.log(job.id());
    for (std::optional<jobs::StepPlace> place(jobs::StepPlace{}); place;) {
      const auto page = context.step_indexes.of(job.id())->page(*log, *place, most_steps_at_once,
                                                                most_bytes_at_once);
      if (!page) return std::nullopt;
      for (const v1::StepReport& step : page->steps) *answer.emplace_back().mutable_step() = step;
      place = page->next;
    }
  } catch (const std::exception& error) {
    log::warn("job {} cannot answer a query: {}", job.id(), error.what());
    return std::nullopt;
  }
  for (const v1::Finding& finding : job.findings())
    *answer.emplace_back().mutable_finding() = finding;
  if (job.has_validity_loss()) *answer.emplace_back().mutable_validity_lost() = job.validity_loss();
  Response::Ended& ended = *answer.emplace_back().mutable_ended();
  ended.set_state(v1::SUCCEEDED);
  ended.set_solver_s(job.last_step().solver_s());
  return answer;
}

/// Lets the thread of a query sleep until its job has another event, and look now and then whether
/// its caller has left.
class Appended final : public jobs::Watcher {
public:
  void on_appended() override {
    {
      const std::lock_guard lock(mutex_);
      appended_ = true;
    }
    changed_.notify_one();
  }
  void wait() {
    constexpr std::chrono::milliseconds longest{20};
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, longest, [this] { return appended_; });
    appended_ = false;
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  bool appended_ = false;
};

/// One query whose case is sound.
class Query {
public:
  Query(Context& context, const Call& call, const v1::QueryButtCurlRequest& request,
        const intake::ExaminedCase& examined, const SendQueryResponse& send)
      : context_(context),
        request_(request),
        examined_(examined),
        call_(call),
        send_(send),
        key_(intake::answer_key(examined.complete, request.attachments())) {}

  /// @return whether the answer was there already
  bool answer_from_store() {
    if (const auto id = context_.store.find_answer(key_, context_.solver)) {
      const auto job = context_.scheduler.find(*id);
      const bool own = !context_.gate.authority().reads_own_only(call_.caller) ||
                       (job && job->owner() == call_.caller.name);
      auto answer = job && own ? answer_of_job(context_, *job) : std::nullopt;
      if (answer) return replay(std::move(*answer), *id);
    }
    if (request_.keep()) return false;
    const auto kept = context_.query_answers.find(key_);
    return kept && replay(read(*kept), "");
  }

  /// Runs it for this answer alone; nothing is left of the run.
  void run(const jobs::CallLimits& waiting) {
    const jobs::CheckFolder folder(context_.query_directory, request_.attachments());
    begin("");
    const RunEnd end = context_.warm_workers
                           .ask(run_request(folder.path()), waiting,
                                [this](const v1::JobEvent& event) { take(event); })
                           .run_end();
    finish(state_of(end.outcome()), end.failure());
    if (end.outcome() == RunEnd::SUCCEEDED) keep_answer();
  }

  /// Runs it as a job that goes first, which stays.
  void run_as_job(const jobs::CallLimits& waiting) {
    check_may_queue(context_, call_);
    jobs::NewJob job = intake::new_job(request_.case_(), request_.attachments(), examined_);
    job.owner = call_.caller.name;
    job.changes = {request_.changes().begin(), request_.changes().end()};
    job.goes_first = true;
    const std::string id = context_.scheduler.submit(job, request_.attachments()).id();
    call_.note->set_job(id);
    call_.note->set_case_sha256(job.case_sha256);
    begin(id);
    const auto log = context_.scheduler.log(id);
    const auto appended = std::make_shared<Appended>();
    context_.logs.watch(id, appended);
    for (jobs::EventLog::Cursor cursor;; appended->wait()) {
      while (const auto event = log->read(cursor)) {
        if (event->state_change().terminal())
          return finish(event->state_change().state(), event->state_change().failure());
        take(*event);
      }
      if (!waiting.called_off()) continue;
      // The daemon that leaves has its jobs go on; only the caller cancels one.
      if (!context_.leaving) context_.scheduler.cancel(id, "the caller of its query has left");
      throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::called_off,
                                     "no one waits for this answer any more");
    }
  }

private:
  bool replay(Responses answer, const std::string& job) {
    send_(accepted(examined_, true, job));
    for (Response& response : answer) send_(std::move(response));
    return true;
  }

  static Responses read(const QueryAnswer& kept) {
    Responses answer(kept.size());
    for (std::size_t i = 0; i < kept.size(); ++i) answer[i].ParseFromString(kept[i]);
    return answer;
  }

  /// Once it has been sent, as bytes: a message takes three times their memory.
  void keep_answer() {
    QueryAnswer kept;
    std::size_t size = 0;
    for (const Response& response : answer_) {
      kept.push_back(response.SerializeAsString());
      size += sizeof kept.back() + kept.back().capacity();
    }
    context_.query_answers.keep(key_, std::make_shared<const QueryAnswer>(std::move(kept)), size);
  }

  v1::WorkerRequest run_request(const std::filesystem::path& folder) const {
    v1::WorkerRequest request;
    v1::SolveCase& order = *request.mutable_solve();
    *order.mutable_case_() = examined_.complete;
    order.set_directory(folder);
    order.set_threads(context_.settings.query_threads());
    v1::CheckpointPolicy& checkpoint = *order.mutable_case_()->mutable_checkpoint();
    checkpoint.set_every_steps(0);  // no one resumes it
    checkpoint.set_every_s(0.0);
    return request;
  }

  /// @param job  its id; empty: none
  void begin(const std::string& job) {
    send_(accepted(examined_, false, job));
    for (const v1::Finding& finding : examined_.verdict.findings()) pass_on(finding);
  }

  void pass_on(Response response) {
    if (!request_.keep()) answer_.push_back(response);
    send_(std::move(response));
  }

  void pass_on(const v1::Finding& finding) {
    const std::string content = finding.SerializeAsString();
    if (std::exchange(reported_[finding.code()], content) == content) return;
    Response response;
    *response.mutable_finding() = finding;
    pass_on(std::move(response));
  }

  void take(const v1::JobEvent& event) {
    Response response;
    if (event.has_finding()) return pass_on(event.finding());
    if (event.has_step() && event.step().step() > last_step_) {  // a resumed run repeats some
      last_step_ = event.step().step();
      solver_s_ = event.step().solver_s();
      *response.mutable_step() = event.step();
    } else if (event.has_validity_lost()) {
      *response.mutable_validity_lost() = event.validity_lost();
    } else {
      return;
    }
    pass_on(std::move(response));
  }

  void finish(v1::JobState state, const v1::Failure& failure) {
    Response response;
    response.mutable_ended()->set_state(state);
    if (state == v1::FAILED) *response.mutable_ended()->mutable_failure() = failure;
    response.mutable_ended()->set_solver_s(solver_s_);
    pass_on(std::move(response));
  }

  Context& context_;
  const v1::QueryButtCurlRequest& request_;
  const intake::ExaminedCase& examined_;
  const Call& call_;
  const SendQueryResponse& send_;
  const std::string key_;
  Responses answer_;                             // of a run that leaves no job
  std::map<std::string, std::string> reported_;  // findings as they were sent, by code
  std::int64_t last_step_ = 0;
  double solver_s_ = 0.0;
};

/// Answers a query, from the store or by a run of its own: `send` is called in order, from this
/// thread. The run ends at once when the call is cancelled.
void answer_query(Context& context, const Call& call, const v1::QueryButtCurlRequest& request,
                  const SendQueryResponse& send) {
  check_changes(request.changes());
  const auto examined = sound_case(context, call, request.case_(), request.attachments());
  Query query(context, call, request, examined, send);
  if (query.answer_from_store()) return;
  jobs::CallLimits waiting = waiting_time(call, longest_query_s);
  waiting.largest_bytes = INT64_MAX;  // its estimate was held against the ceiling
  request.keep() ? query.run_as_job(waiting) : query.run(waiting);
}

/// One query: what the thread of its run has passed on and gRPC has not sent yet.
class QueryStream final : public MessageStream<Response> {
public:
  QueryStream(WorkPool& lane, CallOrigin origin, Context& context, v1::QueryButtCurlRequest request)
      : MessageStream(lane, std::move(origin)), context_(context), request_(std::move(request)) {}

private:
  /// Runs from the beginning to the end of the query, whose responses are sent meanwhile.
  void open(const Call& caller) override {
    set_open();
    Call call = caller;
    call.cancelled = [this, &caller] { return caller.cancelled() || context_.leaving; };
    grpc::Status status = guarded([&] {
      answer_query(context_, call, request_,
                   [this](Response response) { send(std::move(response)); });
    });
    if (status.error_code() == grpc::CANCELLED && context_.leaving)
      status = {grpc::UNAVAILABLE, "dccastd is shutting down; ask again later"};
    const std::lock_guard lock(mutex_);
    end_ = std::move(status);
  }

  std::size_t kept_bytes() const override { return request_.ByteSizeLong(); }

  void send(Response response) {
    {
      const std::lock_guard lock(mutex_);
      waiting_.push_back(std::move(response));
    }
    wake();
  }

  NextMessage<Response> next() override {
    const std::lock_guard lock(mutex_);
    if (waiting_.empty()) return {.end = end_};
    NextMessage<Response> found{.message = std::move(waiting_.front())};
    waiting_.pop_front();
    return found;
  }

  Context& context_;
  const v1::QueryButtCurlRequest request_;
  std::mutex mutex_;  ///< of all below
  std::deque<Response> waiting_;
  std::optional<grpc::Status> end_;
};

}  // namespace

SimulationService::Stream<v1::QueryButtCurlResponse>* SimulationService::QueryButtCurl(
    Wire* wire, const v1::QueryButtCurlRequest* request) {
  return begin_stream<QueryStream>(lanes_.queries, origin_of(wire, *request), context_, *request);
}

}  // namespace dccast::service
