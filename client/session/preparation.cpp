#include "client/session/preparation.hpp"

#include <fmt/format.h>

#include <utility>

#include "client/model/answer.hpp"
#include "client/session/case_faults.hpp"
#include "client/session/data_study.hpp"
#include "proto/case_file/override.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {

namespace {

using Attachments = google::protobuf::RepeatedPtrField<v1::Attachment>;

constexpr int members = 64;
constexpr int most_pairs = 16;

/// Begin of the digest of a case and its files.
std::string digest_of(const v1::Case& plan, const Attachments& attachments) {
  values::Sha256 digest;
  digest.add(plan.SerializeAsString());
  for (const v1::Attachment& file : attachments) digest.add(file.name() + '\n' + file.sha256());
  return digest.finish().substr(0, 16);
}

/// Labels of the studies of a plan.
struct Labels {
  std::string ensemble, pairs, levers;
};

/// The quality of the case does not count: the studies have their own.
Labels labels_of(v1::Case plan, const Attachments& attachments) {
  plan.clear_quality();
  const std::string digest = digest_of(plan, attachments);
  return {"ensemble=" + digest, "pairs=" + digest, "levers=" + digest};
}

/// The newest study with a label that was not cancelled.
std::optional<v1::Study> labelled(Connection& connection, const std::string& label) {
  v1::ListStudiesRequest request;
  request.add_labels(label);

  std::optional<v1::Study> newest;
  read_studies(connection, std::move(request), [&](const v1::Study& study) {
    if (study.state() != v1::STUDY_CANCELLED) newest = study;
    return !newest;
  });
  return newest;
}

/// Makes the runs of a study of this quality, whatever the case says.
void set_quality(v1::Quality quality, const char* name, v1::CreateStudyRequest& request) {
  request.mutable_case_()->set_quality(quality);
  *request.add_changes() = case_file::change_of("quality", name);
}

/// The data of the first members that count, once more at engineering quality.
void lay_out_pairs(const v1::StudyResult& ensemble, v1::CreateStudyRequest& request) {
  set_quality(v1::ENGINEERING, "engineering", request);
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::LIST);
  sweep.set_purpose(v1::SweepPlan::UNCERTAINTY);
  for (const auto& axis : ensemble.study().sweep().axes()) sweep.add_axes()->set_key(axis.key());

  int pairs = 0;
  for (const v1::StudyRun& run : ensemble.runs()) {
    if (run.state() != v1::SUCCEEDED || run.beyond_validity()) continue;
    for (int axis = 0; axis < sweep.axes_size(); ++axis)
      sweep.mutable_axes(axis)->add_values(run.values(axis));
    if (++pairs == most_pairs) return;
  }
  if (pairs == 0)
    throw CommandFailed(ExitCode::solve_failed,
                        fmt::format("no run of the ensemble counts; see dccast studies show {}",
                                    ensemble.study().id()));
}

}  // namespace

std::optional<Preparation> find_preparation(Connection& connection, const v1::Case& plan,
                                            const Attachments& attachments) {
  const Labels labels = labels_of(plan, attachments);
  const auto ensemble = labelled(connection, labels.ensemble);
  if (!ensemble) return std::nullopt;
  return Preparation{*ensemble, labelled(connection, labels.pairs),
                     labelled(connection, labels.levers)};
}

std::optional<Preparation> prepare(Connection& connection, const StudyCase& base,
                                   const std::function<void(const v1::Study&)>& await) {
  const CaseUnderCheck checked = read_case(base.file, changes_of(base.set));
  v1::SubmitJobRequest files;
  name_files(checked, files);
  const Labels labels = labels_of(checked.description, files.attachments());

  std::optional<Preparation> there =
      find_preparation(connection, checked.description, files.attachments());
  if (!there) {
    const auto ensemble = create_study(connection, base, [&](v1::CreateStudyRequest& request) {
      set_quality(v1::DRAFT, "draft", request);
      request.add_labels(labels.ensemble);
      lay_out_uncertainty({.runs = members, .seed = 0, .only = {}}, request);
    });
    if (!ensemble) return std::nullopt;
    there = Preparation{*ensemble, std::nullopt, std::nullopt};
  }
  await(there->ensemble);

  if (!there->pairs) {
    const v1::StudyResult ensemble = evaluate_study(connection, there->ensemble.id());
    there->pairs = create_study(connection, base, [&](v1::CreateStudyRequest& request) {
      request.add_labels(labels.pairs);
      lay_out_pairs(ensemble, request);
    });
    if (!there->pairs) return std::nullopt;
  }
  await(*there->pairs);

  if (!there->levers) {
    there->levers = create_study(connection, base, [&](v1::CreateStudyRequest& request) {
      request.add_labels(labels.levers);
      request.mutable_levers();
    });
    if (!there->levers) return std::nullopt;
  }
  await(*there->levers);
  return there;
}

std::string find_or_run_plan(Connection& connection, const v1::SubmitJobRequest& submission) {
  const std::string label = "plan=" + digest_of(submission.case_(), submission.attachments());
  v1::ListJobsRequest known;
  known.add_labels(label);
  for (const v1::JobState state : {v1::QUEUED, v1::RUNNING, v1::SUCCEEDED}) known.add_states(state);
  const JobListing listing = list_jobs(connection, known, 1);
  if (!listing.jobs.empty()) return listing.jobs.front().id();

  // The casting begins now: its forecast waits for this run.
  v1::SubmitJobRequest run = submission;
  run.set_request_id(values::random_uuid());
  run.add_labels(label);
  run.set_priority(v1::HIGH);
  v1::Job job;
  check(submit_with_retries(connection, run, job), connection.server());
  return job.id();
}

}  // namespace dccast::client
