#include "server/studies/study_requests.hpp"

#include <fmt/format.h>
#include <google/protobuf/util/message_differencer.h>

#include <algorithm>
#include <utility>

#include "proto/values/digests.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/log.hpp"
#include "server/studies/study_file.hpp"
#include "server/studies/study_view.hpp"

namespace dccast::studies {

namespace {

using google::protobuf::util::MessageDifferencer;

/// Whether two requests for the same case differ in nothing but the number of levels of a
/// refinement.
bool same_plan(v1::CreateStudyRequest a, v1::CreateStudyRequest b) {
  // The draft of a recipe follows from the case.
  for (v1::CreateStudyRequest* request : {&a, &b})
    if (request->has_recipe()) request->mutable_recipe()->clear_draft();
  return a.plan_case() == b.plan_case() &&
         (a.has_refinement() || (MessageDifferencer::Equals(a.mould(), b.mould()) &&
                                 MessageDifferencer::Equals(a.recipe(), b.recipe()) &&
                                 MessageDifferencer::Equals(a.remedy(), b.remedy()) &&
                                 MessageDifferencer::Equals(a.sweep(), b.sweep())));
}

/// The runs of a plan, still without jobs.
std::vector<RunRecord> runs_to_queue(int count) {
  std::vector<RunRecord> runs(count);
  for (int i = 0; i < count; ++i) runs[i].number = i;
  return runs;
}

}  // namespace

void StudyRequests::recover() {
  std::filesystem::create_directories(state_.options.directory);
  for (const StudyRecord& study : state_.store.removing()) remove_now(study);
  remove_orphaned_attachments(state_.options.directory, state_.store.ids());
  for (const std::string& id : state_.store.ids())
    if (!std::filesystem::exists(study_file(state_.options.directory, id)))
      write_study_file(state_.options.directory, state_.store.find(id).value());
}

v1::Study StudyRequests::create(const v1::CreateStudyRequest& request,
                                const jobs::Attachments& attachments, const std::string& owner) {
  const std::string sha256 =
      intake::fingerprint(state_.intake.complete_case(request.case_(), attachments).complete,
                          case_file::Same::input, attachments);
  const std::lock_guard lock(mutex_);

  // A request that is repeated after a lost answer creates nothing new.
  if (!request.request_id().empty())
    if (auto there = state_.store.find_request(request.request_id())) {
      if (there->owner != owner)
        throw jobs::RequestIdTaken("another user has created a study with this request_id");
      return extend(std::move(*there), request, sha256);
    }

  if (const std::string reason = state_.scheduler.held(); !reason.empty())
    throw jobs::StorageHeld(fmt::format("the queue is held and takes no study now: {}", reason));

  return create_new(request, attachments, owner, sha256);
}

std::optional<jobs::Attachments> StudyRequests::complete(v1::CreateStudyRequest& request) const {
  const auto before = state_.store.find(request.sweep().further_of());
  if (!before) return std::nullopt;
  *request.mutable_case_() = before->request.case_();
  *request.mutable_attachments() = before->request.attachments();
  return study_attachments(state_.options.directory, *before);
}

v1::Study StudyRequests::create_new(const v1::CreateStudyRequest& request,
                                    const jobs::Attachments& attachments, const std::string& owner,
                                    const std::string& case_sha256) {
  StudyRecord record;
  record.id = values::is_uuid(request.request_id()) ? request.request_id() : values::random_uuid();
  record.owner = owner;
  record.created_ms = record.changed_ms = jobs::milliseconds(jobs::now());
  record.case_sha256 = case_sha256;
  record.request = request;

  // Attachments before the row: a crash in between leaves no study without them.
  const int runs = state_.plan_of(record)->runs();
  const jobs::RequestIdTaken taken("there is a study " + record.id + " already");
  if (state_.store.find(record.id)) throw taken;  // its files must stay as they are
  write_study_attachments(state_.options.directory, record.id, attachments);
  if (!state_.store.insert(record, runs_to_queue(runs))) throw taken;
  state_.write_file(record);

  log::info("study {}: {} runs", record.id, runs);
  feeder_.wake();
  return study_view(state_, record);
}

v1::Study StudyRequests::extend(StudyRecord record, const v1::CreateStudyRequest& request,
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
    state_.store.extend(record, {runs.begin() + before, runs.end()});
    state_.write_file(record);
    state_.plans.forget(record.id);
  }

  // Runs whose jobs were deleted are queued again.
  std::vector<RunRecord> deleted;
  for (const RunAndJob& each : state_.runs_and_jobs(record))
    if (each.deleted()) deleted.push_back(each.run);
  queue_again(record, deleted);
  feeder_.wake();
  return study_view(state_, record);
}

void StudyRequests::queue_again(const StudyRecord& record, std::vector<RunRecord> runs) {
  for (RunRecord& run : runs) run = {.number = run.number, .attempt = run.attempt, .failure = {}};
  state_.append_to_file(record, runs);
  state_.store.queue_again(record.id, runs);
}

std::optional<v1::Study> StudyRequests::find(const std::string& id) const {
  const auto record = state_.store.find(id);
  return record ? std::optional(study_view(state_, *record)) : std::nullopt;
}

std::vector<v1::Study> StudyRequests::list(const StudyStore::Page& page) const {
  std::vector<v1::Study> studies;
  for (const StudyRecord& record : state_.store.list(page))
    studies.push_back(study_view(state_, record));
  return studies;
}

StudyReply StudyRequests::cancel(const std::string& id, const std::string& reason) {
  const auto record = state_.store.find(id);
  if (!record) return {StudyReply::Kind::not_found};
  if (study_view(state_, *record).state() == v1::STUDY_RUNNING) {
    const std::lock_guard lock(state_.queueing_mutex);
    std::vector<RunRecord> waiting = state_.store.runs(id);
    std::erase_if(waiting, [](const RunRecord& run) { return !run.to_queue(); });
    for (RunRecord& run : waiting) run.outcome = v1::CANCELLED;
    state_.append_to_file(*record, waiting);
    state_.store.cancel_waiting(id, jobs::milliseconds(jobs::now()));
  }

  // Also in a study that has ended: a job beside its runs may be left.
  for (const auto& [job, about] : state_.jobs_of(*record))
    if (!jobs::is_terminal(about.state())) state_.scheduler.cancel(job, reason);
  state_.note_change(id);
  return {StudyReply::Kind::done, study_view(state_, state_.store.find(id).value_or(*record))};
}

void StudyRequests::add_next_run(const StudyRecord& record) {
  const auto plan = state_.plan_of(record);
  const auto runs = state_.store.runs(record.id);
  RunRecord next;
  next.number = runs.back().number + 1;
  if (plan->outlasts_failures() && next.number >= plan->runs() && next.number < plan->most_runs())
    state_.store.extend(record, {next});
}

StudyReply StudyRequests::resume(const std::string& id, bool failed) {
  const std::lock_guard lock(mutex_);
  const auto record = state_.store.find(id);
  if (!record) return {StudyReply::Kind::not_found};

  std::vector<RunRecord> again;
  for (const RunAndJob& each : state_.runs_and_jobs(*record)) {
    if (each.deleted()) continue;  // a user has deleted its job on purpose
    const bool lost = each.state() == v1::FAILED || each.state() == v1::CANCELLED;
    if (lost && (failed || !by_the_case_itself(each.failure()))) again.push_back(each.run);
  }

  queue_again(*record, again);
  if (!again.empty()) add_next_run(*record);
  state_.note_change(id);
  feeder_.wake();
  return {StudyReply::Kind::done, study_view(state_, *record)};
}

StudyReply StudyRequests::remove(const std::string& id) {
  const std::lock_guard lock(mutex_);
  const auto record = state_.store.find(id);
  if (!record) return {StudyReply::Kind::not_found};
  const v1::Study study = study_view(state_, *record);
  if (study.state() == v1::STUDY_RUNNING) return {StudyReply::Kind::wrong_state, study};
  for (const auto& [job, about] : state_.jobs_of(*record))
    if (!jobs::is_terminal(about.state())) return {StudyReply::Kind::wrong_state, study, job};

  state_.store.begin_removal(id);
  remove_now(*record);
  state_.note_change(id);
  log::info("study {}: deleted by request", id);
  return {StudyReply::Kind::done};
}

void StudyRequests::remove_now(const StudyRecord& study) {
  const std::string& id = study.id;
  for (const auto& [job, about] : state_.jobs_of(study)) {
    state_.scheduler.remove(job);
    results_.forget(job);
  }
  remove_study_file(state_.options.directory, id);
  state_.store.erase(id);
  surfaces_.forget(id);
  state_.plans.forget(id);
}

}  // namespace dccast::studies
