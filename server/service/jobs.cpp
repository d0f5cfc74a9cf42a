// Calls about jobs. Their results are in results.cpp.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "proto/values/printable.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/logs/readings_log.hpp"
#include "server/service/forecasts.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/refusals.hpp"
#include "server/service/simulation_service.hpp"
#include "server/service/submissions.hpp"

namespace dccast::service {

using Unary = SimulationService::Unary;

namespace {

void check_case_file(const std::string& text) {
  constexpr std::size_t longest = 1 << 20;
  if (text.size() > longest) refuse(Remedy{"leave it empty"}, "case_file is longer than 1 MiB");
}

void check_time_limit(double seconds, double most) {
  const bool within = seconds > 0.0 && std::isfinite(seconds) && (most == 0.0 || seconds <= most);
  if (within || seconds == 0.0) return;
  refuse("time_limit_s must be positive{}",
         most > 0.0 ? fmt::format(" and at most per_case.maximum_time = {} s", std::lround(most))
                    : "");
}

/// The address becomes an argument of a command: no blank, and nothing that looks like an option.
void check_mail(const std::string& mail) {
  check_text("mail", mail);
  const auto at = mail.find('@');
  if (!mail.empty() && (at == 0 || at == std::string::npos || mail.front() == '-' ||
                        mail.find_first_of(" ,;<>") != std::string::npos))
    refuse("mail must be one address, like anna@example.org");
}

/// Adds and removes labels. A label `name=value` replaces every other label of that name.
void change_labels(const v1::UpdateJobRequest& request, v1::Job& job) {
  std::vector<std::string> labels(job.labels().begin(), job.labels().end());
  const auto drop = [&labels](const std::string& name) {
    std::erase_if(labels, [&](const std::string& label) {
      return label == name || label.starts_with(name + "=");
    });
  };

  for (const std::string& name : request.remove_labels()) drop(name);
  for (const std::string& label : request.set_labels()) {
    drop(label.substr(0, label.find('=')));
    labels.push_back(label);
  }
  job.mutable_labels()->Assign(labels.begin(), labels.end());
}

/// What a request changes, for the audit log.
std::string changes_text(const v1::UpdateJobRequest& request) {
  if (request.has_pinned()) return request.pinned() ? "pinned" : "not pinned";
  if (request.priority() == v1::PRIORITY_UNSPECIFIED) return "labels";
  return "priority " + v1::Priority_Name(request.priority());
}

/// The study that a caller names. @throws Refusal  there is none, or the caller may not read it
v1::Study readable_study(Context& context, const Call& call, const std::string& id) {
  check_study_id(id);
  const auto& reading = access::rule_of(*v1::GetStudyRequest::descriptor());
  if (const auto status = context.gate.permit_touch(call.caller, reading, id); !status.ok())
    throw Refusal{status};
  return of_study(id, context.studies.requests().find(id));
}

/// The same of a sweep. @throws Refusal  it is none
v1::Study readable_sweep(Context& context, const Call& call, const std::string& id) {
  v1::Study study = readable_study(context, call, id);
  if (!study.has_sweep())
    refuse(Remedy{"name one of `dccast uncertainty` or `dccast sweep`"},
           "study {} has no runs over data of a case", id);
  return study;
}

/// Checks the name of the line of a casting, and that it is no line of another user.
void check_line(Context& context, const access::Caller& caller, const std::string& name) {
  check_line_name(name);
  const auto& changing = access::rule_of(*v1::RestartLineRequest::descriptor());
  const grpc::Status status = context.gate.permit_touch(caller, changing, name);
  if (status.error_code() == grpc::NOT_FOUND)  // one that the caller may not read
    refuse(ErrorInfo::NOT_PERMITTED, Remedy{"choose another name"}, "a line \"{}\" is not yours",
           name);
  if (!status.ok()) throw Refusal{status};
}

/// Checks the study on which the advice for a casting rests.
void check_levers(Context& context, const Call& call, const std::string& id) {
  if (!readable_study(context, call, id).has_levers())
    refuse(Remedy{"make it by `dccast follow --prepare`"},
           "study {} has no levers that are moved while it is cast", id);
}

/// Checks the studies on which the forecast of a casting rests.
void check_ensemble(Context& context, const Call& call, const v1::Following& following) {
  if (following.ensemble().empty()) {
    if (!following.pairs().empty())
      refuse(Remedy{"name the ensemble too"}, "pairs without an ensemble have no counterparts");
    return;
  }

  const v1::Study ensemble = readable_sweep(context, call, following.ensemble());
  if (following.pairs().empty()) return;
  const v1::Study pairs = readable_sweep(context, call, following.pairs());
  const bool same_keys = std::ranges::equal(ensemble.sweep().axes(), pairs.sweep().axes(), {},
                                            &v1::SweepPlan::Axis::key, &v1::SweepPlan::Axis::key);
  if (!same_keys)
    refuse(Remedy{"make the pairs by `dccast follow --prepare`"},
           "the pairs, study {}, are over other keys than the ensemble, study {}", pairs.id(),
           ensemble.id());
}

/// Checks gauges and studies of a job that follows a casting.
void check_following(Context& context, const Call& call, const v1::SubmitJobRequest& request) {
  constexpr double largest_m = 1.0;
  if (!jobs::fits_record(request.following()))
    refuse(Remedy{"give fewer gauges, with shorter names"},
           "gauges and studies of the casting take {} bytes; about {} are permitted",
           request.following().ByteSizeLong(), jobs::longest_entry);

  std::set<std::string_view> monitors, with_gauge;
  for (const v1::Monitor& monitor : request.case_().monitor()) monitors.insert(monitor.name());
  for (const v1::Gauge& gauge : request.following().gauges()) {
    if (!monitors.contains(gauge.monitor()))
      refuse(Remedy{"name a monitor of the case"}, "the case has no monitor \"{}\"",
             values::shortened(gauge.monitor()));
    if (!with_gauge.insert(gauge.monitor()).second)
      refuse(Remedy{"give one gauge a monitor"}, "the monitor \"{}\" has two gauges",
             values::shortened(gauge.monitor()));
    const bool sound = gauge.noise_m() > 0.0 && gauge.noise_m() <= largest_m &&
                       gauge.zero_m() >= 0.0 && gauge.zero_m() <= largest_m;
    if (!sound)
      refuse(Remedy{"give standard deviations in metres"},
             "the gauge at \"{}\" has a noise of {:g} m and a zero of {:g} m; above 0 to 1 m and "
             "0 to 1 m are permitted",
             values::shortened(gauge.monitor()), gauge.noise_m(), gauge.zero_m());
  }

  check_ensemble(context, call, request.following());
  if (const std::string& levers = request.following().levers(); !levers.empty())
    check_levers(context, call, levers);
  if (const std::string& plan = request.following().plan_job(); !plan.empty())
    readable_job(context, call.caller, plan);
  if (const std::string& line = request.following().line(); !line.empty())
    check_line(context, call.caller, line);
}

/// Refuses a job that could never start. Permission is checked for each predecessor, so that the
/// refusal reveals nothing of jobs that the caller may not read.
void check_jobs_before(Context& context, const access::Caller& caller,
                       const v1::SubmitJobRequest& request) {
  constexpr int most = 100;
  if (request.after_size() > most) refuse("a job waits for at most 100 others");
  for (const std::string& id : request.after()) {
    const v1::Job job = readable_job(context, caller, id);
    if (jobs::is_terminal(job.state()) && !jobs::ends_as_awaited(job.state(), request.after_end()))
      refuse(ErrorInfo::WRONG_STATE, "job {} is {}; nothing can come after its {}", job.id(),
             v1::JobState_Name(job.state()),
             request.after_end() == v1::AWAITED_FAILURE ? "failure" : "success");
  }
}

void check_begin(const v1::SubmitJobRequest& request) {
  constexpr std::int64_t longest_s = 366 * 86400;
  if (!request.has_begin_time()) return;
  if (request.has_following())
    refuse(Remedy{"leave out begin_time"}, "a job that follows a casting starts with it");
  const std::int64_t latest = jobs::now().seconds() + longest_s;
  if (request.begin_time().seconds() < 0 || request.begin_time().seconds() > latest)
    refuse(Remedy{"give a time within a year"}, "begin_time is {} s after 1970",
           request.begin_time().seconds());
}

void change_priority(v1::Priority priority, v1::Job& job) {
  if (priority == v1::PRIORITY_UNSPECIFIED || priority == job.priority()) return;
  if (job.state() != v1::QUEUED && job.state() != v1::PAUSED)
    refuse_state(job, "its priority counts until it starts");
  job.set_priority(priority);
}

/// Refuses a job in the study of another user: the owner of a study changes and deletes all its
/// jobs.
void check_joins_own_study(Context& context, const access::Caller& caller, const std::string& id) {
  check_study_of_job(id);
  if (id.empty()) return;
  const auto study = context.studies.requests().find(id);
  if (!study || study->owner() == caller.name) return;
  if (context.gate.authority().reads_own_only(caller)) throw Refusal{unknown_study(id)};
  refuse(ErrorInfo::NOT_PERMITTED, Remedy{"submit the job without a study, or for one of your own"},
         "study {} is of {}, and holds jobs of its owner alone", id,
         study->owner().empty() ? "no known user" : study->owner());
}

/// Submits a job on a line, whose name no other user takes meanwhile. After a crash in between, the
/// next daemon adds the casting. @throws refusal::LimitReached
v1::Job submit_on_line(Context& context, const Call& call, const jobs::NewJob& job,
                       const jobs::Attachments& attachments) {
  const std::string& name = job.following->line();
  const auto line = context.lines.reserve(name, call.caller.name);
  check_line(context, call.caller, name);

  v1::Job submitted = context.scheduler.submit(job, attachments);
  v1::Case complete;
  complete.ParseFromString(job.description.complete_case);
  line.add(studies::make_line_casting(submitted, *job.following, complete));
  return submitted;
}

/// Each star doubles the worst cost of matching a title.
void check_pattern(const std::string& title) {
  constexpr std::ptrdiff_t most_stars = 5;
  check_text("title", title);
  if (std::ranges::count(title, '*') > most_stars) refuse("the title has more than 5 stars");
}

/// The jobs that a request selects, reduced to those its caller may read.
jobs::JobStore::Page select_jobs(const Context& context, const Call& call,
                                 const v1::ListJobsRequest& request) {
  check_study_of_job(request.study());
  check_labels(request.labels());
  check_pattern(request.title());

  const AgePage page = read_page("the list of jobs", request.page_token(), request.page_size());

  jobs::JobStore::Page wanted;
  wanted.before_ms = page.before_ms;
  wanted.before_id = page.before_id;
  wanted.size = page.size;

  for (const int state : request.states())
    wanted.states.push_back(static_cast<v1::JobState>(state));
  wanted.study = request.study();
  wanted.owner = owner_of_list(context, call, request.owner());
  wanted.since_ms = jobs::milliseconds(request.since());
  wanted.title = request.title();
  wanted.id_prefix = request.id_prefix();
  wanted.labels.assign(request.labels().begin(), request.labels().end());
  return wanted;
}

/// Cuts a text between two UTF-8 characters.
void cut(std::string& text, std::size_t most) {
  if (text.size() <= most) return;

  std::size_t end = most;
  // Bytes 10xxxxxx continue a character.
  while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  text.resize(end);
  text += "...";
}

/// Reduces a job to what a list can carry: first cuts its title to 1 KiB, then drops the monitors
/// of its last step, then the residuals and texts of its failure.
void fit_into_list(v1::Job& job) {
  constexpr std::size_t most_of_a_title = 1024;
  constexpr std::size_t most_of_a_job = 64 * 1024;
  constexpr int most_residuals = 1000;

  cut(*job.mutable_title(), most_of_a_title);
  if (job.ByteSizeLong() <= most_of_a_job) return;

  if (job.has_last_step()) job.mutable_last_step()->clear_monitors();
  if (!job.has_failure()) return;

  v1::Finding& failure = *job.mutable_failure();
  cut(*failure.mutable_message(), most_of_a_job / 8);
  if (failure.residual_history_size() > most_residuals)
    failure.mutable_residual_history()->Truncate(most_residuals);

  while (failure.ByteSizeLong() > most_of_a_job / 2 && failure.further_size() > 0)
    failure.mutable_further()->RemoveLast();
}

/// Adds jobs until the page is full, by number or by bytes, and then names the next page.
void fill(Context& context, jobs::JobStore::Page rest, v1::ListJobsResponse& response) {
  // Rows are fetched a few at a time: a page is bounded in bytes, too.
  constexpr int rows_at_a_time = 32;

  const int size = rest.size;
  std::size_t bytes = 0;
  for (;;) {
    // One row more than the page holds shows whether there is a next page.
    rest.size = std::min(rows_at_a_time, size + 1 - response.jobs_size());
    auto jobs = context.scheduler.list(rest);
    const bool last_rows = static_cast<int>(jobs.size()) < rest.size;

    for (v1::Job& job : jobs) {
      fit_into_list(job);
      add_casting(context, job);
      bytes += job.ByteSizeLong();
      const bool full = response.jobs_size() == size || bytes > page_bytes;
      if (full && response.jobs_size() > 0)
        return response.set_next_page_token(age_token(*response.jobs().rbegin()));
      *response.add_jobs() = std::move(job);
    }

    if (last_rows) return;
    const v1::Job& last = *response.jobs().rbegin();
    rest.before_ms = jobs::milliseconds(last.create_time());
    rest.before_id = last.id();
  }
}

/// A cursor into the job's event log.
class JobStream final : public MessageStream<v1::JobEvent>, public jobs::Watcher {
public:
  JobStream(WorkPool& pool, CallOrigin origin, Context& context, v1::WatchJobRequest request)
      : MessageStream(pool, std::move(origin)), context_(context), request_(std::move(request)) {}

  void on_appended() override { wake(); }

private:
  void open(const Call&) override {
    find_job(context_, request_.id());
    log_ = context_.scheduler.log(request_.id());
    cursor_.sequence = std::max<std::int64_t>(request_.from_sequence(), 1);

    if (cursor_.sequence > log_->last_sequence() + 1)
      refuse(ErrorInfo::OUT_OF_RANGE, Remedy{"watch from one of them, or the next"},
             "job {} has {} events so far", request_.id(), log_->last_sequence());
    context_.logs.watch(request_.id(), std::static_pointer_cast<JobStream>(shared_from_this()));
  }

  NextMessage<v1::JobEvent> next() override {
    try {
      if (auto event = log_->read(cursor_)) {
        intake::make_printable(*event);
        return {.message = std::move(*event)};
      }
    } catch (const std::exception& error) {
      log::error("{}", error.what());
      refuse(ErrorInfo::DAMAGED, Remedy{"`dccastd check` says what is left of it"}, "{}",
             error.what());
    }

    if (log_->terminal_event()) return {.end = grpc::Status::OK};
    if (context_.leaving)
      refuse(ErrorInfo::SHUTTING_DOWN,
             Remedy{fmt::format("the job goes on when it is back: watch again from {}",
                                cursor_.sequence)},
             "dccastd is shutting down");
    return {};
  }

  Context& context_;
  const v1::WatchJobRequest request_;
  std::shared_ptr<jobs::EventLog> log_;
  jobs::EventLog::Cursor cursor_;
};

}  // namespace

SoundSubmission examine(Context& context, const Call& call, const v1::SubmitJobRequest& request) {
  check_joins_own_study(context, call.caller, request.study());
  check_text("request_id", request.request_id());
  check_labels(request.labels());
  check_changes(request.changes());
  check_time_limit(request.time_limit_s(), context.settings.per_case().maximum_time_s());
  check_mail(request.mail());
  check_case_file(request.case_file());
  check_jobs_before(context, call.caller, request);
  check_begin(request);
  if (request.has_following()) check_following(context, call, request);

  auto attachments = uploaded_files(context, call, request.attachments());
  auto examined = sound_case(context, call, request.case_(), attachments);
  return {std::move(examined), std::move(attachments)};
}

v1::Job submit(Context& context, const Call& call, const v1::SubmitJobRequest& request,
               const SoundSubmission& sound) {
  jobs::NewJob made = intake::new_job(request.case_(), sound.attachments, sound.examined);
  made.case_file = request.case_file();

  v1::Job& job = made.description.job;
  job.set_request_id(request.request_id());
  job.set_study(request.study());
  job.set_priority(request.priority());
  job.set_owner(call.caller.name);
  job.set_owner_is_listed(call.caller.by != access::ProvenBy::local_user);
  *job.mutable_labels() = request.labels();
  *job.mutable_changes() = request.changes();
  *job.mutable_after() = request.after();
  job.set_after_end(request.after_end());
  if (request.has_begin_time()) *job.mutable_begin_time() = request.begin_time();
  job.set_time_limit_s(request.time_limit_s());
  job.set_mail(request.mail());

  if (request.has_following()) {
    made.following = request.following();
    // Its results are those of the casting, not of the case alone.
    made.description.answer_key.clear();
    if (!made.following->line().empty())
      return submit_on_line(context, call, made, sound.attachments);
  }
  return context.scheduler.submit(made, sound.attachments);
}

Unary* SimulationService::SubmitJob(Wire* wire, const v1::SubmitJobRequest* request, v1::Job* job) {
  const auto sound = std::make_shared<SoundSubmission>();
  const auto check = [=, this](const Call& call) { *sound = examine(context_, call, *request); };
  const auto keep = [=, this](const Call& call) {
    check_may_queue(context_, call, request->request_id());
    *job = submit(context_, call, *request, *sound);
    call.note->set_job(job->id());
    call.note->set_case_sha256(job->case_sha256());
  };
  return answer(wire, *request, {{pools_.checks, check}, {pools_.durable, keep}});
}

Unary* SimulationService::GetJob(Wire* wire, const v1::GetJobRequest* request, v1::Job* job) {
  return answer(wire, *request, pools_.status, [=, this](const Call&) {
    *job = find_job(context_, request->id());
    add_casting(context_, *job);
    if (job->state() != v1::CANCELLED) return;
    if (const auto end = context_.scheduler.log(request->id())->terminal_event())
      job->set_cause(end->state_change().cause());
    intake::make_printable(*job);
  });
}

Unary* SimulationService::ListJobs(Wire* wire, const v1::ListJobsRequest* request,
                                   v1::ListJobsResponse* response) {
  return answer(wire, *request, pools_.status, [=, this](const Call& call) {
    fill(context_, select_jobs(context_, call, *request), *response);
  });
}

Unary* SimulationService::CancelJob(Wire* wire, const v1::CancelJobRequest* request, v1::Job* job) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    check_text("reason", request->reason());
    *job = done(context_.scheduler.cancel(request->id(), request->reason()), request->id());
  });
}

Unary* SimulationService::PauseJob(Wire* wire, const v1::PauseJobRequest* request, v1::Job* job) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    *job = done(context_.scheduler.pause(request->id()), request->id());
  });
}

Unary* SimulationService::ResumeJob(Wire* wire, const v1::ResumeJobRequest* request, v1::Job* job) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    *job = done(context_.scheduler.resume(request->id()), request->id(),
                "it is not paused and goes on by itself");
  });
}

Unary* SimulationService::DeleteJob(Wire* wire, const v1::DeleteJobRequest* request,
                                    v1::DeleteJobResponse*) {
  return answer(wire, *request, pools_.durable, [=, this](const Call&) {
    done(context_.scheduler.remove(request->id()), request->id(), "cancel it first");
  });
}

Unary* SimulationService::UpdateJob(Wire* wire, const v1::UpdateJobRequest* request, v1::Job* job) {
  return answer(wire, *request, pools_.durable, [=, this](const Call& call) {
    const auto change = [&](v1::Job& found) {
      change_labels(*request, found);
      if (request->has_pinned()) found.set_pinned(request->pinned());
      change_priority(request->priority(), found);
      check_labels(found.labels());
    };

    const jobs::Reply reply = context_.scheduler.mark(request->id(), change);
    call.note->set_reason(changes_text(*request));
    *job = done(reply, request->id());
  });
}

SimulationService::Stream<v1::JobEvent>* SimulationService::WatchJob(
    Wire* wire, const v1::WatchJobRequest* request) {
  return begin_stream<JobStream>(pools_.status, origin_of(wire, *request), context_, *request);
}

}  // namespace dccast::service
