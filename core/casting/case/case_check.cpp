#include "core/casting/case/case_check.hpp"

#include <fmt/format.h>

#include "core/casting/case/checks.hpp"
#include "core/mesh/plan_file.hpp"

namespace dccast::casting {

std::string with_unit(double value, const char* unit) {
  return fmt::format("{:.6g} {}", value, unit);
}

namespace {

/// Whether a fault at `path` makes the value of `key` unusable: `path` is the key itself, a part of
/// it ("schedule.casting_speed[1]"), or its table; a fault of the card makes all keys of the alloy
/// unusable.
bool covers(std::string_view path, std::string_view key) {
  const auto within = [](std::string_view part, std::string_view whole) {
    return part.starts_with(whole) &&
           (part.size() == whole.size() || part[whole.size()] == '.' || part[whole.size()] == '[');
  };
  return within(path, key) || within(key, path) ||
         (path == "alloy.card" && key.starts_with("alloy."));
}

void check_mesh(CaseFindings& found) {
  const mesh::SectionSpec& section = found.casting.section;
  if (mesh::has_plan_file(section))
    check_plan_file(found);
  else if (mesh::has_mesh_file(section))
    check_imported_mesh(found);
  else
    check_built_in_size(found);
}

}  // namespace

std::string CaseFindings::fault_of(std::string_view key) const {
  for (const std::string& path : faulty_keys_)
    if (covers(path, key)) return path;
  for (const Fault& found : faults.list())
    if (covers(found.field, key)) return found.field;
  return {};
}

bool CaseFindings::sound(const Keys& keys) {
  bool sound = true;
  for (const std::string& key : keys) {
    const std::string path = fault_of(key);
    if (path.empty()) continue;
    waited_for_.insert(path);
    sound = false;
  }
  return sound;
}

const mesh::Base<3>& CaseFindings::built_in_plan() {
  if (!built_in_plan_) built_in_plan_ = mesh::base_of<3>(casting.section, mesh::Plan::heat);
  return *built_in_plan_;
}

CheckedCase CaseFindings::answer() {
  for (const std::string& key : waited_for_)
    warning(key, "", "further checks wait until this is fixed");
  return {std::move(faults), std::move(warnings_), estimate};
}

CheckedCase check(const Case& casting_case, const std::vector<std::string>& faulty_keys) {
  CaseFindings found(casting_case, faulty_keys);

  // Single values and tables first: the later checks skip what depends on a faulty key.
  check_alloy(found);
  check_zones(found);
  check_tables(found);
  check_levers(found);
  check_row_size(found);
  check_section(found);
  check_quarter_slab(found);
  check_gap_water(found);
  check_bowl(found);
  check_block_profile(found);
  check_time(found);
  check_mechanics(found);

  // These compute the course of the casting and its mesh, on which the last checks rest.
  check_course(found);
  check_mesh(found);
  check_temperature_file(found);
  check_drain_holes(found);

  check_monitors(found);
  check_plausibility(found);
  advise(found);

  return found.answer();
}

}  // namespace dccast::casting
