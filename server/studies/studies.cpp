// The requests about studies. How runs become jobs is in study_feeder.cpp, their results in
// evaluation.cpp.
#include "server/studies/studies.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <climits>
#include <utility>

#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/study_file.hpp"

namespace dccast::studies {

namespace {

using google::protobuf::util::MessageDifferencer;

bool lost(v1::JobState state) {
  return state == v1::FAILED || state == v1::CANCELLED;
}

/// Whether two requests differ in nothing but the number of levels of a refinement.
bool same_plan(const v1::CreateStudyRequest& a, const v1::CreateStudyRequest& b) {
  return a.plan_case() == b.plan_case() &&
         (a.has_refinement() || (MessageDifferencer::Equals(a.mould(), b.mould()) &&
                                 MessageDifferencer::Equals(a.recipe(), b.recipe()) &&
                                 MessageDifferencer::Equals(a.remedy(), b.remedy()) &&
                                 MessageDifferencer::Equals(a.sweep(), b.sweep())));
}

v1::StudyState state_of(const RunCounts& counts) {
  if (counts.ended() < counts.all()) return v1::STUDY_RUNNING;
  if (counts.of(v1::CANCELLED) > 0 || counts.all() == 0) return v1::STUDY_CANCELLED;
  return counts.of(v1::FAILED) > 0 ? v1::STUDY_FAILED : v1::STUDY_SUCCEEDED;
}

std::string message_of(const RunCounts& counts, v1::StudyState state) {
  if (counts.all() == 0) return "all jobs of the study were deleted";
  if (state == v1::STUDY_FAILED)
    return fmt::format("{} of {} runs failed", counts.of(v1::FAILED), counts.all());
  if (state == v1::STUDY_CANCELLED)
    return fmt::format("{} of {} runs were cancelled", counts.of(v1::CANCELLED), counts.all());
  return {};
}

void add_counts(const RunCounts& counts, v1::Study& study) {
  study.set_runs(counts.all());
  study.set_queued(counts.of(v1::QUEUED) + counts.of(v1::PAUSED));
  study.set_running(counts.of(v1::RUNNING));
  study.set_succeeded(counts.of(v1::SUCCEEDED));
  study.set_failed(counts.of(v1::FAILED));
  study.set_cancelled(counts.of(v1::CANCELLED));
}

void add_plan(const v1::CreateStudyRequest& request, v1::Study& study) {
  if (request.has_refinement()) *study.mutable_refinement() = request.refinement();
  if (request.has_sweep()) *study.mutable_sweep() = request.sweep();
  if (request.has_mould()) *study.mutable_mould() = request.mould();
  if (request.has_remedy()) *study.mutable_remedy() = request.remedy();
  if (request.has_levers()) *study.mutable_levers() = request.levers();
  if (request.has_recipe()) {
    *study.mutable_recipe() = request.recipe();
    study.mutable_recipe()->clear_draft();  // it is as large as a case, and no list needs it
  }
}

[[noreturn]] void refuse_taken(const std::string& id) {
  throw jobs::RequestIdTaken("there is a study " + id + " already");
}

/// The runs of a plan, still without jobs.
std::vector<RunRecord> runs_to_queue(int count) {
  std::vector<RunRecord> runs(count);
  for (int i = 0; i < count; ++i) runs[i].number = i;
  return runs;
}

}  // namespace

Studies::Studies(StudyOptions options, StudyStore& store, jobs::Scheduler& scheduler,
                 const intake::CaseIntake& intake)
    : options_(std::move(options)),
      store_(store),
      scheduler_(scheduler),
      intake_(intake),
      surface_keeper_([this](const std::string& id) { ready_surface(id); }) {
  // Called when a job of a study changes its state: the next run may be queued, or dropped.
  scheduler_.observe([this](const v1::Job& job) {
    if (job.study().empty()) return;
    note_change(job.study());
    wake_feeder();
  });
}

Studies::~Studies() {
  stop();
}

void Studies::recover() {
  std::filesystem::create_directories(options_.directory);
  for (const StudyRecord& study : store_.removing()) remove_now(study);
  remove_orphaned_attachments(options_.directory, store_.ids());
  for (const std::string& id : store_.ids()) {
    StudyRecord record = store_.find(id).value();
    const bool changed = move_attachments_out(options_.directory, record);
    if (changed || !std::filesystem::exists(study_file(options_.directory, id)))
      write_study_file(options_.directory, record);
    if (changed) store_.extend(record, {});
  }
}

void Studies::start() {
  feeder_ = std::jthread([this](const std::stop_token& stop) { feed(stop); });
  constexpr int likely_asked = 5;  // of the studies that are there, the newest
  for (const StudyRecord& study : store_.list({.size = likely_asked}))
    surface_keeper_.look_at(study.id);
}

void Studies::stop() {
  scheduler_.observe({});
  surface_keeper_.stop();
  if (!feeder_.joinable()) return;
  feeder_.request_stop();
  feeder_.join();
}

v1::Study Studies::create(const v1::CreateStudyRequest& request,
                          const jobs::Attachments& attachments, const std::string& owner) {
  const std::string sha256 = intake::fingerprint(request.case_(), attachments);
  const std::lock_guard lock(requests_mutex_);

  // A request that is repeated after a lost answer creates nothing new.
  if (!request.request_id().empty())
    if (auto there = store_.find_request(request.request_id())) {
      if (there->owner != owner)
        throw jobs::RequestIdTaken("another user has created a study with this request_id");
      return take_up(std::move(*there), request, sha256);
    }

  if (const std::string reason = scheduler_.held(); !reason.empty())
    throw jobs::StorageHeld(fmt::format("the queue is held and takes no study now: {}", reason));

  return create_new(request, attachments, owner, sha256);
}

std::optional<jobs::Attachments> Studies::complete(v1::CreateStudyRequest& request) const {
  const auto before = store_.find(request.sweep().further_of());
  if (!before) return std::nullopt;
  *request.mutable_case_() = before->request.case_();
  *request.mutable_attachments() = before->request.attachments();
  return study_attachments(options_.directory, *before);
}

v1::Study Studies::create_new(const v1::CreateStudyRequest& request,
                              const jobs::Attachments& attachments, const std::string& owner,
                              const std::string& case_sha256) {
  StudyRecord record;
  record.id = values::is_uuid(request.request_id()) ? request.request_id() : values::random_uuid();
  record.owner = owner;
  record.created_ms = record.changed_ms = jobs::milliseconds(jobs::now());
  record.case_sha256 = case_sha256;
  record.request = request;

  // Attachments before the row: a crash in between leaves no study without them.
  const int runs = plan_of(record)->runs();
  if (store_.find(record.id)) refuse_taken(record.id);  // its files must stay as they are
  write_study_attachments(options_.directory, record.id, attachments);
  if (!store_.insert(record, runs_to_queue(runs))) refuse_taken(record.id);
  write_study_file(options_.directory, record);

  log::info("study {}: {} runs", record.id, runs);
  wake_feeder();
  return view(record);
}

v1::Study Studies::take_up(StudyRecord record, const v1::CreateStudyRequest& request,
                           const std::string& case_sha256) {
  if (record.case_sha256 != case_sha256 || !same_plan(record.request, request))
    throw jobs::RequestIdTaken(
        fmt::format("request_id \"{}\" was used for another {} (study {})", request.request_id(),
                    record.case_sha256 != case_sha256 ? "case" : "plan", record.id));

  // A refinement study may be continued to finer levels.
  const int before = record.request.refinement().levels();
  if (request.refinement().levels() > before) {
    record.request.mutable_refinement()->set_levels(request.refinement().levels());
    auto runs = runs_to_queue(request.refinement().levels());
    store_.extend(record, {runs.begin() + before, runs.end()});
    {
      const std::lock_guard lock(files_mutex_);
      write_study_file(options_.directory, record);
    }
    plans_.forget(record.id);
  }

  // Runs whose jobs were deleted are queued again.
  std::vector<RunRecord> deleted;
  for (const RunAndJob& each : runs_and_jobs(record))
    if (each.deleted()) deleted.push_back(each.run);
  queue_again(record, deleted);
  wake_feeder();
  return view(record);
}

/// Records runs without a job in the study's file before the rows of the index change.
void Studies::keep(const StudyRecord& record, const std::vector<RunRecord>& runs) {
  const std::lock_guard lock(files_mutex_);
  if (!std::filesystem::exists(study_file(options_.directory, record.id)))
    write_study_file(options_.directory, record);
  append_runs(options_.directory, record.id, runs);
}

void Studies::queue_again(const StudyRecord& record, std::vector<RunRecord> runs) {
  for (RunRecord& run : runs) run = {.number = run.number, .attempt = run.attempt, .failure = {}};
  keep(record, runs);
  store_.queue_again(record.id, runs);
}

v1::Study Studies::view(const StudyRecord& record) {
  const RunCounts counts = store_.counts(record.id);
  v1::Study study;
  study.set_id(record.id);
  study.set_title(record.request.case_().title());
  study.set_request_id(record.request.request_id());
  study.set_owner(record.owner);
  *study.mutable_create_time() = jobs::timestamp(record.created_ms);
  *study.mutable_labels() = record.request.labels();

  add_plan(record.request, study);
  add_counts(counts, study);
  study.set_state(state_of(counts));
  study.set_message(message_of(counts, study.state()));

  // A growing plan ends with the run that failed: show its reason.
  if (study.state() == v1::STUDY_FAILED && record.request.has_mould())
    for (const EvaluatedRun& evaluated : evaluated_runs(record, {}))
      if (evaluated.run.state() == v1::FAILED) {
        study.set_message(study.message() + ": " + evaluated.run.failure().message());
        break;
      }

  // Running jobs count by their progress.
  double done = counts.ended();
  if (counts.of(v1::RUNNING) > 0)
    for (const v1::Job& job : scheduler_.list({.states = {v1::RUNNING},
                              .study = record.id,
                              .owner = record.owner,
                              .size = counts.of(v1::RUNNING)}))
      done += job.last_step().progress();

  // The number of a recipe's runs is known before its later rounds are planned.
  const bool grows = record.request.has_recipe() && study.state() == v1::STUDY_RUNNING;
  const int runs = grows ? plan_of(record)->most_runs() : counts.all();
  study.set_progress(runs == 0 ? 1.0 : std::min(1.0, done / runs));

  if (study.state() != v1::STUDY_RUNNING)
    *study.mutable_end_time() = jobs::timestamp(std::max(record.changed_ms, counts.last_end_ms));
  return study;
}

std::optional<v1::Study> Studies::find(const std::string& id) {
  const auto record = store_.find(id);
  return record ? std::optional(view(*record)) : std::nullopt;
}

std::vector<v1::Study> Studies::list(const StudyStore::Page& page) {
  std::vector<v1::Study> studies;
  for (const StudyRecord& record : store_.list(page)) studies.push_back(view(record));
  return studies;
}

StudyReply Studies::cancel(const std::string& id, const std::string& reason) {
  const auto record = store_.find(id);
  if (!record) return {StudyReply::Kind::not_found};
  if (view(*record).state() == v1::STUDY_RUNNING) {
    const std::lock_guard lock(queueing_mutex_);
    std::vector<RunRecord> waiting = store_.runs(id);
    std::erase_if(waiting, [](const RunRecord& run) { return !run.to_queue(); });
    for (RunRecord& run : waiting) run.outcome = v1::CANCELLED;
    keep(*record, waiting);
    store_.cancel_waiting(id, jobs::milliseconds(jobs::now()));
  }

  // Also in a study that has ended: a job beside its runs may be left.
  for (const auto& [job, about] : jobs_of(*record))
    if (!jobs::is_terminal(about.state())) scheduler_.cancel(job, reason);
  note_change(id);
  return {StudyReply::Kind::done, view(store_.find(id).value_or(*record))};
}

/// A plan that had no further run because of those that were lost may have one now.
void Studies::grow_again(const StudyRecord& record) {
  const auto plan = plan_of(record);
  const auto runs = store_.runs(record.id);
  RunRecord next;
  next.number = runs.back().number + 1;
  if (plan->outlasts_failures() && next.number >= plan->runs() && next.number < plan->most_runs())
    store_.extend(record, {next});
}

StudyReply Studies::resume(const std::string& id, bool failed) {
  const std::lock_guard lock(requests_mutex_);
  const auto record = store_.find(id);
  if (!record) return {StudyReply::Kind::not_found};

  std::vector<RunRecord> again;
  for (const RunAndJob& each : runs_and_jobs(*record)) {
    if (each.deleted()) continue;  // a user has deleted its job on purpose
    const auto& [run, job] = each;

    const v1::JobState state = job ? job->state() : run.outcome;
    const v1::Finding& failure = job ? job->failure() : run.failure;
    if (lost(state) && (failed || !by_the_case_itself(failure))) again.push_back(run);
  }

  queue_again(*record, again);
  if (!again.empty()) grow_again(*record);
  note_change(id);
  wake_feeder();
  return {StudyReply::Kind::done, view(*record)};
}

StudyReply Studies::remove(const std::string& id) {
  const std::lock_guard lock(requests_mutex_);
  const auto record = store_.find(id);
  if (!record) return {StudyReply::Kind::not_found};
  const v1::Study study = view(*record);
  if (study.state() == v1::STUDY_RUNNING) return {StudyReply::Kind::wrong_state, study};
  for (const auto& [job, about] : jobs_of(*record))
    if (!jobs::is_terminal(about.state())) return {StudyReply::Kind::wrong_state, study, job};

  store_.begin_removal(id);
  remove_now(*record);
  note_change(id);
  log::info("study {}: deleted by request", id);
  return {StudyReply::Kind::done};
}

void Studies::remove_now(const StudyRecord& study) {
  const std::string& id = study.id;
  for (const auto& [job, about] : jobs_of(study)) {
    scheduler_.remove(job);
    histories_.forget(job);
    faces_.forget(job);
  }
  remove_study_file(options_.directory, id);
  store_.erase(id);
  predictions_.forget(id);
  plans_.forget(id);
}

std::map<std::string, v1::Job> Studies::jobs_of(const StudyRecord& study) {
  std::map<std::string, v1::Job> jobs;
  for (v1::Job& job : scheduler_.list({.study = study.id, .size = INT_MAX}))
    if (job.owner() == study.owner) jobs[job.id()] = std::move(job);
  return jobs;
}

std::vector<Studies::RunAndJob> Studies::runs_and_jobs(const StudyRecord& study) {
  // The runs first: the feeder may queue a run in between, whose job an older list would lack.
  std::vector<RunRecord> runs = store_.runs(study.id);
  auto jobs = jobs_of(study);

  std::vector<RunAndJob> joined;
  for (RunRecord& run : runs) {
    std::optional<v1::Job> job;
    if (const auto found = jobs.find(run.job); found != jobs.end()) job = std::move(found->second);
    joined.push_back({std::move(run), std::move(job)});
  }
  return joined;
}

std::shared_ptr<const StudyPlan> Studies::plan_of(const StudyRecord& record) {
  if (const auto kept = plans_.find(record.id)) return kept;
  return plans_.keep(record.id, study_plan(record.request));
}

}  // namespace dccast::studies
