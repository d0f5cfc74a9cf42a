#include "client/session/data_study.hpp"

#include <algorithm>
#include <set>

#include "client/session/case_faults.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {

using case_file::leading_number, case_file::range_of, case_file::rounded;

namespace {

v1::ValidateCaseResponse validated(Connection& connection, const v1::CreateStudyRequest& request) {
  v1::ValidateCaseRequest question;
  *question.mutable_case_() = request.case_();
  *question.mutable_attachments() = request.attachments();
  v1::ValidateCaseResponse verdict = connection.call(&Stub::ValidateCase, question);
  if (verdict.has_complete()) return verdict;
  if (verdict.faults().empty())
    throw CommandFailed(ExitCode::unreachable,
                        "this dccastd is older than the command: update the server");
  std::string text = "the case has faults:";
  for (const v1::Fault& fault : verdict.faults())
    text += "\n  " + case_file::describe(fault, case_file::SourceMap());
  throw invalid(text);
}

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

std::string sources_of(const v1::Calibration& calibration) {
  std::set<std::string> sources;
  for (const auto& curve : calibration.curves()) sources.insert(curve.measured().source());
  std::string text;
  for (const std::string& source : sources) text += (text.empty() ? "" : ", ") + source;
  return text;
}

/// A calibrated key as text: value and ends of its range, which contain the value.
struct Written {
  std::string low, best, high;
};

Written written(const v1::Calibration::Key& key) {
  const Written exact{key.low() < key.best() ? key.low_text() : key.best_text(), key.best_text(),
                      key.high() > key.best() ? key.high_text() : key.best_text()};
  const Written short_one{rounded(exact.low), rounded(exact.best), rounded(exact.high)};
  return short_one.low == short_one.high ? exact : short_one;
}

/// The range relative to the new value, as in [uncertainty].
std::string range_after(const std::string& axis_key, const Written& key) {
  const double low = leading_number(key.low), best = leading_number(key.best),
               high = leading_number(key.high);
  if (axis_key.ends_with(".scale"))
    return rounded(case_file::number_text(low / best)) + ".." +
           rounded(case_file::number_text(high / best)) + " times";
  if (axis_key.ends_with(".offset")) {
    const auto unit = std::min(key.best.find(' '), key.best.size());
    return "± " + rounded(case_file::number_text(std::max(high - best, best - low))) +
           key.best.substr(unit);
  }
  v1::SweepPlan::Axis axis;
  axis.add_values(key.low);
  axis.add_values(key.high);
  return range_of(axis);
}

/// The path of a key without a place in its table.
std::string table_of(const std::string& key) {
  return key.ends_with(']') ? key.substr(0, key.rfind('[')) : key;
}

/// Applies a change to what the file gives; values of card and defaults are written out.
void apply(const v1::CaseChange& change, v1::Case& complete, v1::Case& description) {
  const auto refuse = [&](const std::vector<v1::Fault>& faults) {
    if (!faults.empty())
      throw invalid(change.key() + " = " + change.value() +
                    " does not fit the case: " + faults.front().message());
  };
  refuse(case_file::apply_changes(complete, {change}));
  v1::Case changed = description;
  if (case_file::apply_changes(changed, {change}).empty()) {
    description = std::move(changed);
    return;
  }
  const std::string key = table_of(datum_of(change.key()));
  for (const auto& [path, value] : case_file::key_values(complete))
    if (path == key)
      return refuse(case_file::apply_changes(description, {case_file::change_of(key, value)}));
  throw invalid(key + " has no value in the case");
}

void set_range(const std::string& key, const std::string& range, v1::Case& description) {
  auto& ranges = *description.mutable_uncertainty();
  const auto found = std::ranges::find(ranges, key, &v1::KeyRange::key);
  v1::KeyRange& line = found == ranges.end() ? *ranges.Add() : *found;
  line.set_key(key);
  line.set_range(range);
}

}  // namespace

v1::Case complete_case(Connection& connection, const v1::CreateStudyRequest& request) {
  return validated(connection, request).complete();
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

v1::StudyJudgement judge_calibration(Connection& connection,
                                     const std::vector<CastingStudies>& castings) {
  v1::JudgeStudyRequest request;
  request.set_id(castings.front().front());
  request.set_with_result(true);
  for (const CastingStudies& casting : castings)
    *request.add_castings()->mutable_studies() = {casting.begin(), casting.end()};
  return connection.call(&Stub::JudgeStudy, request);
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
    request.set_request_id(casting.front() + "/" +
                           values::sha256(sweep.SerializeAsString()).substr(0, 16));
    const v1::Study study = connection.call(&Stub::CreateStudy, request);
    if (std::ranges::find(casting, study.id()) != casting.end()) continue;
    casting.push_back(study.id());
    added.push_back(study.id());
  }
  return added;
}

std::string calibrated_case(Connection& connection, const v1::CreateStudyRequest& request,
                            const v1::StudyResult& result) {
  const v1::Calibration& calibration = result.calibration();
  const std::string source = "calibrated from " + sources_of(calibration);
  v1::Case complete = complete_case(connection, request);
  v1::Case description = request.case_();
  std::string header =
      "# " + source + " by dccast calibrate, study " + result.study().id() +
      ".\n# Values are those of the most central draw; ranges hold 9 of 10 draws.\n";
  std::set<std::string> keys;
  for (int axis = 0; axis < calibration.keys_size(); ++axis) {
    const auto& before = result.study().sweep().axes(axis);
    const Written key = written(calibration.keys(axis));
    apply(case_file::change_of(before.key(), key.best), complete, description);
    const std::string datum = datum_of(before.key());
    keys.insert(datum);
    set_range(datum, range_after(before.key(), key), description);
    header += "#   " + before.key() + " = " + key.best + "; before: " + range_of(before) +
              ", after: " + key.low + " to " + key.high + "\n";
    constexpr std::size_t most_provenance = 100;  // of the schema
    if (datum.starts_with("alloy."))
      description.mutable_alloy()->set_provenance(source.substr(0, most_provenance));
  }
  std::string text = case_file::to_toml(description);
  for (const std::string& key : keys) {
    const auto line = text.find("\n" + case_file::quoted(key) + " = ");
    if (line != std::string::npos) text.insert(text.find('\n', line + 1), "  # " + source);
  }
  return header + "\n" + text;
}

}  // namespace dccast::client
