#include "server/studies/data_axes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>
#include <string>

#include "proto/case_file/fingerprint.hpp"
#include "proto/case_file/study_keys.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::studies {
namespace {

using case_file::UncertainKey;
using case_file::without_ranges;

constexpr const char* how_to_give_ranges =
    "give some in [uncertainty] of the case (docs/uncertainty.md)";

void set_ends(v1::SweepPlan::Axis& axis, const std::string& key, const std::string& low,
              const std::string& high) {
  axis.set_key(key);
  axis.clear_values();
  axis.add_values(low);
  axis.add_values(high);
}

void set_ends(v1::SweepPlan::Axis& axis, const UncertainKey& datum) {
  set_ends(axis, datum.change(), datum.ends.low, datum.ends.high);
}

/// A case with its defaults, and its data that have a range.
struct Completed {
  v1::Case description;
  std::vector<UncertainKey> data;
  std::vector<v1::Fault> faults;
};

Completed complete(const intake::CaseIntake& intake, const jobs::Attachments& attachments,
                   const v1::Case& submitted) {
  auto examined = intake.complete_case(submitted, attachments);
  Completed completed{std::move(examined.complete), {}, {}};
  const auto& faults = examined.verdict.faults();
  completed.faults.assign(faults.begin(), faults.end());
  if (!completed.faults.empty()) return completed;

  completed.data = case_file::uncertain_keys(completed.description);
  // A depth that follows the block goes on to follow it when a run moves the block, and steps that
  // follow the events of the start when a run moves these.
  if (!submitted.section().has_initial_depth_m())
    completed.description.mutable_section()->clear_initial_depth_m();
  if (!submitted.time().has_step_s()) completed.description.mutable_time()->clear_step_s();
  return completed;
}

/// The draft with the ranges of its data, from which the plan draws them.
std::vector<v1::Fault> lay_out_levers(const intake::CaseIntake& intake,
                                      const jobs::Attachments& attachments,
                                      v1::CreateStudyRequest& request) {
  request.mutable_case_()->set_quality(v1::DRAFT);
  Completed draft = complete(intake, attachments, request.case_());
  if (!draft.faults.empty()) return draft.faults;
  *request.mutable_case_() = draft.description;
  return {};
}

/// Gives axes without values the ends of their ranges.
std::vector<v1::Fault> fill_named_axes(const std::vector<UncertainKey>& data,
                                       v1::SweepPlan& sweep) {
  std::vector<v1::Fault> faults;
  for (v1::SweepPlan::Axis& axis : *sweep.mutable_axes()) {
    if (!axis.values().empty()) continue;
    const auto found = std::ranges::find(data, axis.key(), &UncertainKey::key);
    if (found != data.end()) {
      set_ends(axis, *found);
      continue;
    }

    std::string known;
    for (const UncertainKey& datum : data)
      known += fmt::format("{}{} = {}", known.empty() ? "" : ", ", datum.key, datum.range);
    faults.push_back(intake::fault_of(axis.key(), "", "has no range", "those with one: " + known,
                                      "give its ends, or a range in [uncertainty]"));
  }
  return faults;
}

/// Adds all data that have a range. A calibration leaves out data that only the schema gives: no
/// one has stated that they are uncertain in this case.
void add_all_data(const std::vector<UncertainKey>& data, v1::SweepPlan& sweep) {
  const bool only_given = sweep.purpose() == v1::SweepPlan::CALIBRATION;
  for (const UncertainKey& datum : data)
    if (!only_given || datum.origin != "default") set_ends(*sweep.add_axes(), datum);
}

/// The levers of the case that are not among its data already.
void add_levers(const v1::Case& description, v1::SweepPlan& sweep) {
  std::set<std::string> data;
  for (const v1::SweepPlan::Axis& axis : sweep.axes()) data.insert(case_file::datum_of(axis.key()));

  for (const case_file::Lever& lever : case_file::levers()) {
    const std::string key = lever.key;
    const bool is_datum = !key.ends_with(".shift") && data.contains(case_file::datum_of(key));
    if (is_datum || (lever.is_there != nullptr && !lever.is_there(description))) continue;
    const auto ends = case_file::parse_range(lever.range);
    set_ends(*sweep.add_axes(), key, ends->low, ends->high);
  }
}

std::vector<v1::Fault> lay_out_sweep(const intake::CaseIntake& intake,
                                     const jobs::Attachments& attachments,
                                     v1::CreateStudyRequest& request) {
  const bool is_chosen = std::ranges::any_of(
      request.changes(), [](const v1::CaseChange& change) { return change.key() == "quality"; });
  if (!is_chosen) request.mutable_case_()->set_quality(v1::DRAFT);

  Completed completed = complete(intake, attachments, request.case_());
  if (!completed.faults.empty()) return completed.faults;
  *request.mutable_case_() = without_ranges(completed.description);

  v1::SweepPlan& sweep = *request.mutable_sweep();
  if (!sweep.axes().empty()) return fill_named_axes(completed.data, sweep);

  add_all_data(completed.data, sweep);
  if (sweep.purpose() == v1::SweepPlan::SENSITIVITY) add_levers(completed.description, sweep);
  if (!sweep.axes().empty()) return {};
  return {intake::fault_of("uncertainty", "", "no key of this case has a range",
                           "one range or more", how_to_give_ranges)};
}

/// Data of a recipe: all with a range but those that the recipe itself sets.
void add_data(const std::vector<UncertainKey>& data, v1::RecipePlan& plan) {
  const std::set<std::string> of_recipe{"schedule.casting_speed", "schedule.water_flow",
                                        "schedule.metal_level",   "schedule.hold",
                                        "schedule.filling",       "time.end"};
  for (const UncertainKey& key : data) {
    if (of_recipe.contains(key.key.substr(0, key.key.find('[')))) continue;
    v1::RecipePlan::Datum& datum = *plan.add_data();
    datum.set_key(key.change());
    datum.set_low(key.ends.low);
    datum.set_high(key.ends.high);
  }
}

std::vector<v1::Fault> lay_out_recipe(const intake::CaseIntake& intake,
                                      const jobs::Attachments& attachments,
                                      v1::CreateStudyRequest& request) {
  v1::Case draft = request.case_();
  draft.set_quality(v1::DRAFT);
  Completed drafts = complete(intake, attachments, draft);
  Completed full = complete(intake, attachments, request.case_());
  if (!full.faults.empty()) return full.faults;
  if (!drafts.faults.empty()) return drafts.faults;

  v1::RecipePlan& plan = *request.mutable_recipe();
  *plan.mutable_draft() = without_ranges(drafts.description);
  *request.mutable_case_() = without_ranges(full.description);
  add_data(drafts.data, plan);
  if (!plan.data().empty()) return {};
  return {intake::fault_of("uncertainty", "", "no key of this case has a range",
                           "one range or more", how_to_give_ranges)};
}

}  // namespace

bool has_data_axes(const v1::CreateStudyRequest& request) {
  if (request.has_levers()) return true;
  if (request.has_recipe()) return !request.recipe().has_draft();
  const v1::SweepPlan& sweep = request.sweep();
  return sweep.purpose() != v1::SweepPlan::PURPOSE_UNSPECIFIED && sweep.further_of().empty();
}

std::vector<v1::Fault> lay_out_axes(const intake::CaseIntake& intake,
                                    const jobs::Attachments& attachments,
                                    v1::CreateStudyRequest& request) {
  if (request.has_levers()) return lay_out_levers(intake, attachments, request);
  return request.has_recipe() ? lay_out_recipe(intake, attachments, request)
                              : lay_out_sweep(intake, attachments, request);
}

}  // namespace dccast::studies
