#include "core/case/check/case_findings.hpp"

#include <cstdio>

namespace dccast::casting {

std::string with_unit(double value, const char* unit) {
  char text[48];
  std::snprintf(text, sizeof text, "%.6g %s", value, unit);
  return text;
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

}  // namespace

std::string CaseFindings::fault_of(std::string_view key) const {
  for (const std::string& path : faulty_keys_) {
    if (covers(path, key)) return path;
  }
  for (const Fault& found : faults.list()) {
    if (covers(found.field, key)) return found.field;
  }
  return {};
}

bool CaseFindings::sound(const Keys& keys) {
  bool all = true;
  for (const std::string& key : keys) {
    const std::string path = fault_of(key);
    if (path.empty()) continue;
    waited_for_.insert(path);
    all = false;
  }
  return all;
}

CheckedCase CaseFindings::answer() {
  for (const std::string& key : waited_for_) {
    warning(key, "", "further checks wait until this is fixed");
  }
  return {std::move(faults), std::move(warnings_), estimate};
}

}  // namespace dccast::casting
