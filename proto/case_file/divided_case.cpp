#include "proto/case_file/divided_case.hpp"

#include <google/protobuf/util/message_differencer.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"

namespace dccast::case_file {
namespace {

void scale_steps(v1::TimeControl& time, double factor) {
  for (double& step : *time.mutable_step_s()->mutable_value()) step *= factor;
  time.set_minimum_step_s(time.minimum_step_s() * factor);
}

/// The casting alone, its steps as they are at refinement 1.
v1::Case undivided(v1::Case description) {
  scale_steps(*description.mutable_time(), description.mesh().refinement());
  description.mutable_mesh()->set_refinement(1);
  description.clear_title();
  description.clear_output();
  description.clear_checkpoint();
  description.clear_limits();
  return description;
}

}  // namespace

v1::Case divided(const v1::Case& description, int parts) {
  v1::Case fine = description;
  apply_quality(fine);
  apply_defaults(*fine.mutable_mesh());
  apply_defaults(*fine.mutable_time());
  fine.mutable_mesh()->set_refinement(fine.mesh().refinement() * parts);
  scale_steps(*fine.mutable_time(), 1.0 / parts);
  return fine;
}

std::string reason_against_dividing(const v1::Case& description) {
  if (!description.mesh().file().empty())
    return "mesh.file: the cells of a mesh file cannot be divided here; make finer files and "
           "compare "
           "their runs, or use the built-in mesh";
  if (!description.thermal().file().empty())
    return "thermal.file: temperatures from a file belong to its nodes and do not become more "
           "exact on "
           "finer meshes; use the heat solver";
  if (description.monitor().empty() ||
      (description.mechanics().has_enabled() && !description.mechanics().enabled()))
    return "the case computes no curl: it needs a [[monitor]] and mechanics.enabled";
  return {};
}

bool is_refined_case(const v1::Case& a, const v1::Case& b) {
  return google::protobuf::util::MessageDifferencer::Equals(undivided(a), undivided(b));
}

}  // namespace dccast::case_file
