#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

/// A casting whose converged corner at 250 s is known (docs/error-bars.md).
struct Truth {
  const char* name;
  double water = 1.0, speed = 1.0;  ///< factors [1]
  double corner_mm, uncertainty_mm;
};

double corner_mm(const Truth& casting, v1::Quality quality) {
  casting::Case c = support::load_case(casting.name, quality);
  c.schedule.water_flow_factor = Curve(casting.water);
  c.schedule.casting_speed_factor = Curve(casting.speed);
  return regression::end_lift_mm(regression::run(c), 0);
}

v1::RelativeError band(const std::string& name, v1::Quality quality) {
  v1::Case description;
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == name) case_file::read_text(shipped.text, name, description);
  description.set_quality(quality);
  case_file::apply_defaults(description);
  return case_file::relative_discretisation_error(description).value();
}

TEST(Start3dBands, HoldTheTruths) {
  const Truth truths[] = {
      {.name = "start-3d-paper", .corner_mm = 39.0, .uncertainty_mm = 0.4},
      {.name = "start-3d-paper", .water = 0.5, .corner_mm = 36.6, .uncertainty_mm = 0.4},
      {.name = "start-3d-paper", .speed = 0.7, .corner_mm = 26.9, .uncertainty_mm = 0.5},
      {.name = "start-3d-aa1050", .corner_mm = 27.7, .uncertainty_mm = 0.8},
      {.name = "start-3d-aa3104", .corner_mm = 37.0, .uncertainty_mm = 0.8},
      {.name = "start-3d-aa6063", .corner_mm = 34.5, .uncertainty_mm = 0.7},
      {.name = "start-3d-aa5182", .corner_mm = 42.2, .uncertainty_mm = 1.2}};

  for (const Truth& truth : truths)
    for (const v1::Quality quality : {v1::DRAFT, v1::ENGINEERING}) {
      const double lift = corner_mm(truth, quality);
      const v1::RelativeError error = band(truth.name, quality);
      EXPECT_LE(lift * (1.0 - error.lower()), truth.corner_mm - truth.uncertainty_mm) << truth.name;
      EXPECT_GE(lift * (1.0 + error.upper()), truth.corner_mm + truth.uncertainty_mm) << truth.name;
    }
}

}  // namespace
}  // namespace dccast
