#include "client/session/data_study.hpp"

#include <algorithm>

#include "client/session/failure.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client {

namespace {

void add_axis(v1::SweepPlan& sweep, const std::string& key, const std::string& low,
              const std::string& high) {
  v1::SweepPlan::Axis& axis = *sweep.add_axes();
  axis.set_key(key);
  axis.add_values(low);
  axis.add_values(high);
}

v1::SweepPlan& hypercube(const DataPlan& plan, v1::SweepPlan::Purpose purpose,
                         v1::CreateStudyRequest& request) {
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::LATIN_HYPERCUBE);
  sweep.set_purpose(purpose);
  sweep.set_runs(plan.runs);
  sweep.set_seed(plan.seed);
  return sweep;
}

/// Names the data that are moved; the server knows their ranges.
void add_names(const std::vector<std::string>& keys, v1::SweepPlan& sweep) {
  for (const std::string& key : keys) sweep.add_axes()->set_key(key);
}

/// An axis from KEY=RANGE, or from KEY with the range that the case has for it.
void add_free(const std::string& text, v1::SweepPlan& sweep) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) return add_names({text}, sweep);

  const auto ends = case_file::parse_range(text.substr(equals + 1));
  if (!ends)
    throw invalid("--free " + text + ": is no range; permitted: " + case_file::range_forms);
  add_axis(sweep, text.substr(0, equals) + ends->suffix, ends->low, ends->high);
}

}  // namespace

v1::Case complete_case(Connection& connection, const v1::CreateStudyRequest& request) {
  v1::ValidateCaseRequest question;
  *question.mutable_case_() = request.case_();
  *question.mutable_attachments() = request.attachments();
  const v1::ValidateCaseResponse verdict = connection.call(&Stub::ValidateCase, question);
  if (verdict.has_complete()) return verdict.complete();

  // A valid case without its completed form: the server does not know this field.
  if (verdict.faults().empty())
    throw CommandFailed(ExitCode::unreachable,
                        "this dccastd is older than the command: update the server");
  std::string text = "the case has faults:";
  for (const v1::Fault& fault : verdict.faults())
    text += "\n  " + case_file::describe(fault, case_file::SourceMap());
  throw invalid(text);
}

void lay_out_calibration(const CalibrationPlan& plan,
                         const google::protobuf::RepeatedPtrField<v1::SweepPlan::Axis>& axes,
                         v1::CreateStudyRequest& request) {
  v1::SweepPlan& sweep = hypercube(plan.data, v1::SweepPlan::CALIBRATION, request);
  *sweep.mutable_measured() = {plan.measured.begin(), plan.measured.end()};
  *sweep.mutable_axes() = axes;
  if (!axes.empty()) return;
  for (const std::string& text : plan.free) add_free(text, sweep);
}

void lay_out_uncertainty(const DataPlan& plan, v1::CreateStudyRequest& request) {
  add_names(plan.only, hypercube(plan, v1::SweepPlan::UNCERTAINTY, request));
}

void lay_out_sensitivity(const DataPlan& plan, v1::CreateStudyRequest& request) {
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::ENDS);
  sweep.set_purpose(v1::SweepPlan::SENSITIVITY);
  add_names(plan.only, sweep);
}

v1::JudgeStudyRequest question_about(const std::vector<CastingStudies>& castings) {
  v1::JudgeStudyRequest request;
  request.set_id(castings.front().front());
  request.set_with_result(true);
  for (const CastingStudies& casting : castings)
    *request.add_castings()->mutable_studies() = {casting.begin(), casting.end()};
  return request;
}

std::vector<std::string> add_checks(Connection& connection, const v1::Calibration& calibration,
                                    const v1::SweepPlan& plan,
                                    std::vector<CastingStudies>& castings) {
  std::vector<std::string> added;
  for (CastingStudies& casting : castings) {
    v1::CreateStudyRequest request;
    v1::SweepPlan& sweep = *request.mutable_sweep();
    sweep.set_design(v1::SweepPlan::LIST);
    sweep.set_purpose(v1::SweepPlan::CALIBRATION);
    sweep.set_further_of(casting.front());

    for (int axis = 0; axis < plan.axes_size(); ++axis) {
      auto& values = *sweep.add_axes();
      values.set_key(plan.axes(axis).key());
      for (const auto& place : calibration.checks()) values.add_values(place.values(axis));
    }

    // An id made of the content: the same command again finds the studies that it has made.
    request.set_find(true);
    const v1::Study study = connection.call(&Stub::CreateStudy, request);
    if (std::ranges::find(casting, study.id()) != casting.end()) continue;
    casting.push_back(study.id());
    added.push_back(study.id());
  }
  return added;
}

}  // namespace dccast::client
