// Near-real-time queries, answered by a new run or by a stored one.
#include <fmt/format.h>

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
#include "server/jobs/executors/precedence.hpp"
#include "server/jobs/log.hpp"
#include "server/service/call_pools.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/refusals.hpp"
#include "server/service/run_history.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

namespace {

using v1::RunEnd;
using Response = v1::QueryButtCurlResponse;
using Responses = std::vector<Response>;

using SendQueryResponse = std::function<void(Response)>;

constexpr double longest_query_s = 24 * 3600.0;

/// First message of an answer.
/// @param job     id of the run's job; empty if the run leaves none
/// @param answer  names the stored answer if there is no job
Response accepted(const intake::ExaminedCase& examined, bool from_store, const std::string& job,
                  const std::string& answer) {
  Response response;
  response.mutable_accepted()->set_from_store(from_store);
  response.mutable_accepted()->set_job(job);
  if (job.empty()) response.mutable_accepted()->set_answer(answer);
  *response.mutable_accepted()->mutable_case_() = examined.complete;
  return response;
}

v1::JobState state_of(RunEnd::Outcome outcome) {
  if (outcome == RunEnd::SUCCEEDED) return v1::SUCCEEDED;
  return outcome == RunEnd::FAILED ? v1::FAILED : v1::CANCELLED;
}

/// Steps, findings and end of a succeeded job, as a query sends them; empty if its history cannot
/// be read.
std::optional<Responses> answer_of_job(Context& context, const v1::Job& job) {
  Responses answer;
  try {
    for (v1::StepReport& step : read_steps(context, job.id()))
      *answer.emplace_back().mutable_step() = std::move(step);
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

/// Lets the thread of a query sleep until its job has another event. It wakes every 20 ms as well,
/// to notice that its caller has left.
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

Response waiting(std::string reason, double expected_s) {
  Response response;
  response.mutable_waiting()->set_reason(std::move(reason));
  response.mutable_waiting()->set_expected_s(expected_s);
  return response;
}

std::string describe(const QueryWait& wait) {
  const int before_it = wait.running + wait.ahead;
  return fmt::format("waiting for {} {}", before_it, before_it == 1 ? "query" : "queries");
}

/// One query. All constructor arguments outlive it.
class Query {
public:
  /// @param complete  case with defaults and alloy card, see CaseIntake::complete_case()
  Query(Context& context, const Call& call, const v1::QueryButtCurlRequest& request,
        const jobs::Attachments& attachments, intake::ExaminedCase complete,
        const SendQueryResponse& send)
      : context_(context),
        request_(request),
        attachments_(attachments),
        examined_(std::move(complete)),
        call_(call),
        send_(send),
        key_(intake::fingerprint(examined_.complete, case_file::Same::answer, attachments)) {}

  /// Sends a stored answer, of a job or of an earlier query. @return whether there was one
  bool answer_from_store() {
    if (const auto id = context_.store.find_answer(key_, context_.solver)) {
      const auto job = context_.scheduler.find(*id);
      const bool own = !context_.gate.authority().reads_own_only(call_.caller) ||
                       (job && job->owner() == call_.caller.name);
      auto answer = job && own ? answer_of_job(context_, *job) : std::nullopt;
      if (answer) return replay(std::move(*answer), *id);
    }

    // A kept run needs its own job, so an answer without one does not serve it.
    if (request_.keep()) return false;
    const auto kept = context_.query_answers.find(key_);
    return kept && kept->succeeded && replay(read(*kept), "");
  }

  /// Replaces the case by the same one after a worker has checked it.
  void set_checked(intake::ExaminedCase checked) { examined_ = std::move(checked); }

  double estimated_s() const { return examined_.verdict.estimate().solver_s(); }
  jobs::Urgency urgency() const {
    return jobs::classify_query(estimated_s(), request_.one_of_several());
  }

  void run() {
    jobs::CallLimits waiting = waiting_time(call_, longest_query_s);
    waiting.largest_bytes = INT64_MAX;  // its estimate was held against the ceiling
    request_.keep() ? run_as_job(waiting) : run_without_job(std::move(waiting));
  }

private:
  /// Runs the case for this answer only; the run leaves no job.
  void run_without_job(jobs::CallLimits waiting) {
    waiting.enter = [this](const jobs::WorkerProcess& worker) { return enter(worker); };
    std::optional<jobs::CheckFolder> folder;
    if (!attachments_.empty()) folder.emplace(context_.query_directory, attachments_);

    begin("");
    const RunEnd end = context_.warm_workers
                           .ask(run_request(folder ? folder->path() : ""), waiting,
                                [this](const v1::JobEvent& event) { take(event); })
                           .run_end();
    finish(state_of(end.outcome()), end.failure());

    keep_answer(end.outcome());
  }

  /// Runs the case as a job that starts first and is kept.
  void run_as_job(const jobs::CallLimits& waiting) {
    check_may_queue(context_, call_);

    jobs::NewJob job = intake::new_job(request_.case_(), attachments_, examined_);
    job.description.job.set_owner(call_.caller.name);
    *job.description.job.mutable_changes() = request_.changes();
    job.goes_first = true;

    const std::string id = context_.scheduler.submit(job, attachments_).id();
    call_.note->set_job(id);
    call_.note->set_case_sha256(job.description.job.case_sha256());
    begin(id);

    // Follow the job's log until its end, or until the caller leaves.
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
      // When the daemon shuts down its jobs continue later; only a caller who leaves cancels one.
      if (!context_.leaving) context_.scheduler.cancel(id, "the caller of its query has left");
      throw jobs::WorkerDidNotAnswer(jobs::WorkerDidNotAnswer::Why::called_off,
                                     "no one waits for this answer any more");
    }
  }

  /// Pauses the worker of this query while more urgent queries run.
  jobs::Precedence::Registration enter(const jobs::WorkerProcess& worker) {
    const auto on_change = [this, &worker](const std::optional<jobs::MoreUrgentRun>& stopped_for) {
      worker.set_stopped(stopped_for.has_value());
      if (stopped_for) report_stop(*stopped_for);
    };
    return context_.precedence.enter({.urgency = urgency(),
                                      .estimated_s = estimated_s(),
                                      .on_change = on_change,
                                      .processor_s = [&worker] { return worker.processor_s(); }});
  }

  /// Reports a pause, but not oftener than every 10 s: short queries may pause this one each
  /// second.
  void report_stop(const jobs::MoreUrgentRun& stopped_for) {
    constexpr std::chrono::seconds between_reports{10};
    const auto now = std::chrono::steady_clock::now();
    if (stop_reported_ && now - *stop_reported_ < between_reports) return;

    stop_reported_ = now;
    send_(waiting(stopped_for.description(), stopped_for.remaining_s));
  }

  bool replay(Responses answer, const std::string& job) {
    send_(accepted(examined_, true, job, key_));
    for (Response& response : answer) send_(std::move(response));
    return true;
  }

  static Responses read(const QueryAnswer& kept) {
    Responses answer(kept.messages.size());
    for (std::size_t i = 0; i < answer.size(); ++i) answer[i].ParseFromString(kept.messages[i]);
    return answer;
  }

  /// Keeps the answer once it has been sent. A failed run is kept too, so that it can be compared.
  void keep_answer(RunEnd::Outcome outcome) {
    if (outcome != RunEnd::SUCCEEDED && outcome != RunEnd::FAILED) return;

    const auto kept = std::make_shared<QueryAnswer>();
    kept->succeeded = outcome == RunEnd::SUCCEEDED;
    kept->complete_case = examined_.complete.SerializeAsString();
    for (const Response& response : answer_) kept->messages.push_back(response.SerializeAsString());

    context_.query_answers.forget(key_);  // keep() would not replace the answer of a failed run
    context_.query_answers.keep(key_, kept, kept->bytes());
  }

  v1::WorkerRequest run_request(const std::filesystem::path& folder) const {
    v1::WorkerRequest request;
    v1::SolveCase& order = *request.mutable_solve();
    *order.mutable_case_() = examined_.complete;

    order.set_directory(folder);
    order.set_threads(context_.settings.queries().threads());
    order.set_nice(jobs::nice_value(urgency()));

    // No one resumes this run.
    v1::CheckpointPolicy& checkpoint = *order.mutable_case_()->mutable_checkpoint();
    checkpoint.set_every_steps(0);
    checkpoint.set_every_s(0.0);
    return request;
  }

  /// @param job  id of the run's job; empty if it leaves none
  void begin(const std::string& job) {
    send_(accepted(examined_, false, job, key_));
    for (const v1::Finding& finding : examined_.verdict.findings()) pass_on(finding);
  }

  void pass_on(Response response) {
    if (!request_.keep()) answer_.push_back(response);
    send_(std::move(response));
  }

  /// Passes a finding on unless it was sent with the same content.
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

  void finish(v1::JobState state, const v1::Finding& failure) {
    Response response;
    response.mutable_ended()->set_state(state);
    if (state == v1::FAILED) *response.mutable_ended()->mutable_failure() = failure;
    response.mutable_ended()->set_solver_s(solver_s_);
    pass_on(std::move(response));
  }

  Context& context_;
  const v1::QueryButtCurlRequest& request_;
  const jobs::Attachments& attachments_;
  intake::ExaminedCase examined_;
  const Call& call_;
  const SendQueryResponse& send_;
  const std::string key_;
  Responses answer_;                             // kept if the run leaves no job
  std::map<std::string, std::string> reported_;  // sent findings, serialised, by code
  std::int64_t last_step_ = 0;
  double solver_s_ = 0.0;
  std::optional<std::chrono::steady_clock::time_point> stop_reported_;
};

/// One query in three stages, each in its own pool: look for a stored answer, check the case, run
/// it. Messages of a stage wait here until gRPC has sent the previous one.
class QueryStream final : public MessageStream<Response> {
public:
  QueryStream(CallPools& pools, CallOrigin origin, Context& context,
              v1::QueryButtCurlRequest request)
      : MessageStream(pools.stored_answers, std::move(origin)),
        pools_(pools),
        context_(context),
        request_(std::move(request)) {}

private:
  bool opens_in_stages() const override { return true; }

  void open(const Call& caller) override {
    set_open();  // responses are sent while the query runs
    call_ = caller;
    call_.cancelled = [this, &caller] { return caller.cancelled() || context_.leaving; };
    do_stage([this] { return look_for_stored_answer(); });
  }

  /// One stage. @return whether the query continues in the thread of another pool
  using Stage = std::function<bool()>;

  bool look_for_stored_answer() {
    check_changes(request_.changes());
    attachments_ = uploaded_files(context_, call_, request_.attachments());

    auto complete = context_.intake.complete_case(request_.case_(), attachments_);
    if (complete.verdict.faults_size() == 0) {
      query_.emplace(context_, call_, request_, attachments_, std::move(complete), send_);
      if (query_->answer_from_store()) return false;
    }
    return hand_over(
        [this](auto work) { return pools_.query_checks.post(std::move(work), kept_bytes()); },
        [this] { return check_case(); });
  }

  bool check_case() {
    auto checked = sound_case(context_, call_, request_.case_(), attachments_);
    query_.value().set_checked(std::move(checked));
    const auto report_wait = [this](const QueryWait& wait) {
      send(waiting(describe(wait), wait.expected_s));
    };

    return hand_over(
        [&](auto work) {
          return pools_.query_turns.post(query_->urgency(), query_->estimated_s(), report_wait,
                                         std::move(work), kept_bytes());
        },
        [this] {
          query_->run();
          return false;
        });
  }

  /// Posts the next stage. The calling thread must not touch the query afterwards.
  /// @throws Refusal  the pool is full
  template <class Post>
  bool hand_over(const Post& post, Stage next) {
    const auto self = this->shared_from_this();
    if (!post([self, this, next = std::move(next)] { do_stage(next); }))
      throw Refusal{too_many_waiting()};
    return true;
  }

  void do_stage(const Stage& stage) {
    bool handed_over = false;
    grpc::Status status = guarded([&] {
      check_wanted(call_);
      handed_over = stage();
    });
    if (handed_over) return;

    // The caller did not leave: the query was cancelled by the shutdown.
    if (status.error_code() == grpc::CANCELLED && context_.leaving)
      status = make_status({.reason = ErrorInfo::SHUTTING_DOWN,
                            .cause = "dccastd is shutting down",
                            .remedy = "ask again later"});

    {
      const std::lock_guard lock(mutex_);
      end_ = status;
    }

    finish_opening(status);
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

  CallPools& pools_;
  Context& context_;
  const v1::QueryButtCurlRequest request_;
  const SendQueryResponse send_ = [this](Response response) { send(std::move(response)); };
  Call call_;
  jobs::Attachments attachments_;
  std::optional<Query> query_;
  std::mutex mutex_;  ///< guards the members below
  std::deque<Response> waiting_;
  std::optional<grpc::Status> end_;
};

}  // namespace

SimulationService::Stream<v1::QueryButtCurlResponse>* SimulationService::QueryButtCurl(
    Wire* wire, const v1::QueryButtCurlRequest* request) {
  return begin_stream<QueryStream>(pools_, origin_of(wire, *request), context_, *request);
}

}  // namespace dccast::service
