#include "proto/case_file/fingerprint.hpp"

#include <google/protobuf/util/json_util.h>

#include <stdexcept>

#include "proto/values/digests.hpp"

namespace dccast::case_file {
namespace {

void clear_what_only_resolves(v1::Case& complete) {
  complete.clear_output();
  complete.clear_limits();
  complete.clear_quality();
  complete.mutable_time()->clear_step_s();
  complete.mutable_time()->clear_minimum_step_s();

  // Some keys of the mesh do not divide it.
  v1::Mesh kept;
  kept.set_element(complete.mesh().element());
  kept.set_growth(complete.mesh().growth());
  kept.set_file(complete.mesh().file());
  *complete.mutable_mesh() = kept;
}

void clear_what_only_judges(v1::Case& complete) {
  complete.clear_plausibility();
  complete.clear_validity();
  complete.clear_monitor();
  complete.clear_time();
}

}  // namespace

std::string fingerprint(v1::Case complete, Same same,
                        const std::map<std::string, std::string>& files) {
  complete.clear_title();
  if (same != Same::input) complete.clear_checkpoint();
  if (same == Same::answer || same == Same::recipe) complete = without_ranges(std::move(complete));
  if (same == Same::casting || same == Same::recipe) clear_what_only_resolves(complete);
  if (same == Same::recipe) clear_what_only_judges(complete);

  std::string text;
  const auto status = google::protobuf::util::MessageToJsonString(complete, &text);
  if (!status.ok()) throw std::runtime_error("the case cannot be written as JSON");
  for (const auto& [name, sha256] : files) text += "\n" + name + " " + sha256;
  return values::sha256(text);
}

v1::Case without_ranges(v1::Case description) {
  description.clear_uncertainty();
  description.mutable_alloy()->clear_uncertainty();
  return description;
}

}  // namespace dccast::case_file
