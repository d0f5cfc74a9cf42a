// What a study found, written into a case file.
#include <fmt/core.h>

#include <algorithm>
#include <set>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/plant_words.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/study_keys.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "server/judging/judged_study.hpp"
#include "server/judging/judgement.hpp"

namespace dccast::judging {
namespace {

using case_file::datum_of, case_file::leading_number, case_file::range_of, case_file::rounded;

std::string sources_of(const v1::Calibration& calibration) {
  std::set<std::string> sources;
  for (const auto& curve : calibration.curves()) sources.insert(curve.measured().source());
  return joined(sources, ", ");
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
    return fmt::format("{}..{} times", rounded(case_file::number_text(low / best)),
                       rounded(case_file::number_text(high / best)));

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
      throw UnfitCase(fmt::format("{} = {} does not fit the case: {}", change.key(), change.value(),
                                  faults.front().message()));
  };
  refuse(case_file::apply_changes(complete, {change}));

  v1::Case changed = description;
  if (case_file::apply_changes(changed, {change}).empty()) {
    description = std::move(changed);
    return;
  }

  // The file does not have the value that the change refers to.
  const std::string key = table_of(datum_of(change.key()));
  for (const auto& [path, value] : case_file::key_values(complete))
    if (path == key)
      return refuse(case_file::apply_changes(description, {case_file::change_of(key, value)}));
  throw UnfitCase(key + " has no value in the case");
}

void set_range(const std::string& key, const std::string& range, v1::Case& description) {
  auto& ranges = *description.mutable_uncertainty();
  const auto found = std::ranges::find(ranges, key, &v1::KeyRange::key);
  v1::KeyRange& line = found == ranges.end() ? *ranges.Add() : *found;
  line.set_key(key);
  line.set_range(range);
}

std::string calibrated_case(const v1::StudyResult& result, const v1::Case& submitted,
                            v1::Case complete) {
  const v1::Calibration& calibration = result.calibration();
  const std::string source = "calibrated from " + sources_of(calibration);
  v1::Case description = submitted;
  std::string header = fmt::format(
      "# {} by dccast calibrate, study {}.\n"
      "# Values are those of the most central draw; ranges hold 9 of 10 draws.\n",
      source, result.study().id());

  std::set<std::string> keys;
  for (int axis = 0; axis < calibration.keys_size(); ++axis) {
    const auto& before = result.study().sweep().axes(axis);
    const Written key = written(calibration.keys(axis));
    apply(case_file::change_of(before.key(), key.best), complete, description);

    const std::string datum = datum_of(before.key());
    keys.insert(datum);
    set_range(datum, range_after(before.key(), key), description);
    header += fmt::format("#   {} = {}; before: {}, after: {} to {}\n", before.key(), key.best,
                          range_of(before), key.low, key.high);

    constexpr std::size_t most_provenance = 100;  // of the schema
    if (datum.starts_with("alloy."))
      description.mutable_alloy()->set_provenance(source.substr(0, most_provenance));
  }

  // Each range has beside it where it comes from.
  std::string text = case_file::to_toml(description);
  for (const std::string& key : keys) {
    const auto line = text.find("\n" + case_file::quoted(key) + " = ");
    if (line != std::string::npos) text.insert(text.find('\n', line + 1), "  # " + source);
  }
  return header + "\n" + text;
}

/// The case with the changes of the recipe that was chosen.
std::string chosen_case(const v1::RecipeFound& found, v1::Case description) {
  const auto& changes = found.front(found.chosen()).changes();
  case_file::apply_changes(description, {changes.begin(), changes.end()});
  return case_file::readable_toml(description);
}

}  // namespace

std::string found_case(const v1::StudyResult& result, const v1::Case& submitted,
                       const v1::Case& complete) {
  if (result.has_calibration()) return calibrated_case(result, submitted, complete);
  if (result.has_recipe() && result.recipe().chosen() >= 0)
    return chosen_case(result.recipe(), submitted);
  return {};
}

}  // namespace dccast::judging
