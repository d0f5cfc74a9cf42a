#include "client/session/calibration.hpp"

#include <algorithm>
#include <set>

#include "client/model/study.hpp"
#include "client/session/data_study.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/values/digests.hpp"

namespace dccast::client {
namespace {

// Root mean squares of a few runs scatter; a surface that is off by more than this does not hold.
constexpr double confirmed_ratio = 2.0;

std::string sources_of(const v1::Calibration& calibration) {
  std::set<std::string> sources;
  for (const auto& curve : calibration.curves()) sources.insert(curve.measured().source());
  std::string text;
  for (const std::string& source : sources) text += (text.empty() ? "" : ", ") + source;
  return text;
}

/// A calibrated key as it is written: value and ends of its range, which hold the value.
struct Written {
  std::string low, best, high;
};

Written written(const v1::Calibration::Key& key) {
  const Written exact{key.low() < key.best() ? key.low_text() : key.best_text(), key.best_text(),
                      key.high() > key.best() ? key.high_text() : key.best_text()};
  const Written short_one{rounded(exact.low), rounded(exact.best), rounded(exact.high)};
  return short_one.low == short_one.high ? exact : short_one;
}

/// The range about the new value, as in [uncertainty].
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

v1::CaseChange change_of(const std::string& key, const std::string& value) {
  v1::CaseChange change;
  change.set_key(key);
  change.set_value(value);
  return change;
}

/// The path of a key without a place in its table.
std::string table_of(const std::string& key) {
  return key.ends_with(']') ? key.substr(0, key.rfind('[')) : key;
}

/// Changes what the file gives; what it leaves to card and defaults is written out.
void apply(const v1::CaseChange& change, v1::Case& complete, v1::Case& description) {
  const auto refuse = [&](const std::vector<v1::Fault>& faults) {
    if (!faults.empty())
      throw CommandFailed(ExitCode::invalid,
                          change.key() + " = " + change.value() +
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
    if (path == key) return refuse(case_file::apply_changes(description, {change_of(key, value)}));
  throw CommandFailed(ExitCode::invalid, key + " has no value in the case");
}

void set_range(const std::string& key, const std::string& range, v1::Case& description) {
  auto& ranges = *description.mutable_uncertainty();
  const auto found = std::ranges::find(ranges, key, &v1::KeyRange::key);
  v1::KeyRange& line = found == ranges.end() ? *ranges.Add() : *found;
  line.set_key(key);
  line.set_range(range);
}

}  // namespace

v1::StudyResult evaluate_calibration(Connection& connection,
                                     const std::vector<CastingStudies>& castings) {
  v1::EvaluateStudyRequest request;
  request.set_id(castings.front().front());
  for (const CastingStudies& casting : castings)
    *request.add_castings()->mutable_studies() = {casting.begin(), casting.end()};
  v1::StudyResult result = connection.call(&Stub::EvaluateStudy, request);
  if (!result.has_calibration() && result.calibration_fault().empty())
    throw CommandFailed(ExitCode::unreachable,
                        "this dccastd is older than the command: update the server");
  return result;
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

bool is_confirmed(const v1::Calibration::Curve& curve) {
  return curve.has_check_error() &&
         curve.check_error() <=
             std::max(confirmed_ratio * curve.checked_error(), curve.noise().median());
}

std::string calibrated_case(Connection& connection, const v1::CreateStudyRequest& request,
                            const v1::StudyResult& result) {
  const v1::Calibration& calibration = result.calibration();
  const std::string source = "calibrated from " + sources_of(calibration);
  v1::Case complete = completed_case(connection, request);
  v1::Case description = request.case_();
  std::string header =
      "# " + source + " by dccast calibrate, study " + result.study().id() +
      ".\n# Values are those of the most central draw; ranges hold 9 of 10 draws.\n";
  std::set<std::string> keys;
  for (int axis = 0; axis < calibration.keys_size(); ++axis) {
    const auto& before = result.study().sweep().axes(axis);
    const Written key = written(calibration.keys(axis));
    apply(change_of(before.key(), key.best), complete, description);
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
