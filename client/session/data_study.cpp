#include "client/session/data_study.hpp"

#include <algorithm>
#include <array>
#include <set>

#include "client/session/case_faults.hpp"
#include "client/session/failure.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::client {
namespace {

/// A lever of a plant with the range in which sensitivity moves it: a tenth, or what a plant
/// changes between two castings.
struct Lever {
  const char* key;
  const char* range;
  bool (*is_there)(const v1::Case&);
};

bool always(const v1::Case&) {
  return true;
}

bool has_points_in_time(const v1::Curve& curve) {
  return curve.value_size() > 1 && curve.abscissa() == v1::TIME;
}

const std::array levers{
    Lever{"schedule.casting_speed.scale", "0.9..1.1", always},
    Lever{
        "schedule.casting_speed.shift", "-10 s..10 s",
        [](const v1::Case& c) { return has_points_in_time(c.schedule().casting_speed_m_per_s()); }},
    Lever{"schedule.water_flow.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.cooling().water().enabled(); }},
    Lever{"schedule.water_flow.shift", "-10 s..10 s",
          [](const v1::Case& c) { return has_points_in_time(c.schedule().water_flow_m2_per_s()); }},
    Lever{"schedule.casting_temperature.offset", "-10 K..10 K", always},
    Lever{"cooling.water.temperature.offset", "-5 K..5 K", always},
    Lever{"cooling.bottom_block.temperature.offset", "-20 K..20 K", always},
    Lever{"schedule.filling.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.schedule().filling_s() > 0.0; }},
    Lever{"schedule.hold.scale", "0.9..1.1",
          [](const v1::Case& c) { return c.schedule().hold_s() > 0.0; }},
    Lever{"section.block_above_water.offset", "-5 mm..5 mm",
          [](const v1::Case& c) { return c.section().has_block_above_water_m(); }},
};

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
  throw CommandFailed(ExitCode::invalid, text);
}

/// At draft quality, unless the changes of the request choose another.
std::vector<case_file::UncertainKey> complete(Connection& connection,
                                              v1::CreateStudyRequest& request) {
  const bool chosen = std::ranges::any_of(
      request.changes(), [](const v1::CaseChange& change) { return change.key() == "quality"; });
  if (!chosen) request.mutable_case_()->set_quality(v1::DRAFT);
  return complete_case(connection, request);
}

void add_axis(v1::SweepPlan& sweep, const std::string& key, const std::string& low,
              const std::string& high) {
  v1::SweepPlan::Axis& axis = *sweep.add_axes();
  axis.set_key(key);
  axis.add_values(low);
  axis.add_values(high);
}

void add_data(const std::vector<case_file::UncertainKey>& keys, const DataPlan& plan,
              v1::SweepPlan& sweep) {
  std::set<std::string> wanted(plan.only.begin(), plan.only.end());
  std::string known;
  for (const case_file::UncertainKey& datum : keys) {
    known += "\n  " + datum.key + " = " + datum.range;
    if (plan.only.empty() || wanted.erase(datum.key) > 0)
      add_axis(sweep, datum.change(), datum.ends.low, datum.ends.high);
  }
  if (!wanted.empty())
    throw CommandFailed(ExitCode::invalid, *wanted.begin() + " has no range; there are:" + known);
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

/// An axis from KEY=RANGE, or from KEY with the range that the case has for it.
void add_free(const std::string& text, const std::vector<case_file::UncertainKey>& known,
              v1::SweepPlan& sweep) {
  const auto equals = text.find('=');
  if (equals == std::string::npos) {
    const auto found = std::ranges::find(known, text, &case_file::UncertainKey::key);
    if (found == known.end())
      throw CommandFailed(ExitCode::invalid,
                          text + " has no range in case or card; write --free '" + text +
                              "=RANGE', RANGE as " + case_file::range_forms);
    return add_axis(sweep, found->change(), found->ends.low, found->ends.high);
  }
  const auto ends = case_file::parse_range(text.substr(equals + 1));
  if (!ends)
    throw CommandFailed(ExitCode::invalid,
                        "--free " + text + ": is no range; permitted: " + case_file::range_forms);
  add_axis(sweep, text.substr(0, equals) + ends->suffix, ends->low, ends->high);
}

}  // namespace

std::vector<case_file::UncertainKey> complete_case(Connection& connection,
                                                   v1::CreateStudyRequest& request) {
  const bool depth_follows_block = !request.case_().section().has_initial_depth_m();
  v1::Case& base = *request.mutable_case_();
  base = validated(connection, request).complete();
  auto keys = case_file::uncertain_keys(base);
  if (depth_follows_block) base.mutable_section()->clear_initial_depth_m();
  base.clear_uncertainty();
  base.mutable_alloy()->clear_uncertainty();
  return keys;
}

void lay_out_calibration(Connection& connection, const CalibrationPlan& plan,
                         const google::protobuf::RepeatedPtrField<v1::SweepPlan::Axis>& axes,
                         v1::CreateStudyRequest& request) {
  auto keys = complete(connection, request);
  v1::SweepPlan& sweep = hypercube(plan.data, v1::SweepPlan::CALIBRATION, request);
  *sweep.mutable_measured() = {plan.measured.begin(), plan.measured.end()};
  *sweep.mutable_axes() = axes;
  if (!axes.empty()) return;
  for (const std::string& text : plan.free) add_free(text, keys, sweep);
  if (plan.free.empty()) {
    std::erase_if(keys, [](const auto& datum) { return datum.origin == "default"; });
    add_data(keys, {}, sweep);
  }
  if (sweep.axes().empty())
    throw CommandFailed(
        ExitCode::invalid,
        "neither case nor card gives a range; name what is free by --free KEY=RANGE");
}

void lay_out_uncertainty(Connection& connection, const DataPlan& plan,
                         v1::CreateStudyRequest& request) {
  const auto keys = complete(connection, request);
  v1::SweepPlan& sweep = hypercube(plan, v1::SweepPlan::UNCERTAINTY, request);
  add_data(keys, plan, sweep);
  if (sweep.axes().empty())
    throw CommandFailed(ExitCode::invalid,
                        "no key of this case has a range; give some in [uncertainty] "
                        "(docs/uncertainty.md)");
}

void lay_out_sensitivity(Connection& connection, const DataPlan& plan,
                         v1::CreateStudyRequest& request) {
  const auto keys = complete(connection, request);
  v1::SweepPlan& sweep = *request.mutable_sweep();
  sweep.set_design(v1::SweepPlan::ENDS);
  sweep.set_purpose(v1::SweepPlan::SENSITIVITY);
  add_data(keys, plan, sweep);
  std::set<std::string> data;
  for (const v1::SweepPlan::Axis& axis : sweep.axes()) data.insert(datum_of(axis.key()));
  for (const Lever& lever : levers) {
    const std::string key = lever.key;
    const bool is_datum = !key.ends_with(".shift") && data.contains(datum_of(key));
    if (!plan.only.empty() || is_datum || !lever.is_there(request.case_())) continue;
    const auto ends = case_file::parse_range(lever.range);
    add_axis(sweep, key, ends->low, ends->high);
  }
}

v1::Case completed_case(Connection& connection, const v1::CreateStudyRequest& request) {
  return validated(connection, request).complete();
}

std::string datum_of(const std::string& axis_key) {
  for (const char* suffix : {".scale", ".offset", ".shift"})
    if (axis_key.ends_with(suffix)) return axis_key.substr(0, axis_key.rfind('.'));
  return axis_key;
}

bool is_lever(const std::string& axis_key) {
  return std::ranges::any_of(levers, [&](const Lever& lever) { return axis_key == lever.key; });
}

}  // namespace dccast::client
