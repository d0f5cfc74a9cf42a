#include <vector>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/override.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

/// A casting whose converged corner at 250 s is known (docs/error-bars.md).
struct Truth {
  const char* name;
  std::vector<v1::CaseChange> changes{};
  double corner_mm, uncertainty_mm;
};

v1::Case description_of(const Truth& casting, v1::Quality quality) {
  v1::Case description;
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == casting.name) case_file::read_text(shipped.text, casting.name, description);
  EXPECT_TRUE(case_file::apply_changes(description, casting.changes).empty()) << casting.name;
  description.set_quality(quality);
  return description;
}

double corner_mm(const Truth& casting, v1::Quality quality) {
  return regression::end_lift_mm(
      regression::run(support::complete_case(description_of(casting, quality))), 0);
}

v1::RelativeError band(const Truth& casting, v1::Quality quality) {
  v1::Case description = description_of(casting, quality);
  case_file::apply_defaults(description);
  return case_file::relative_discretisation_error(description).value();
}

TEST(Start3dBands, HoldTheTruths) {
  const auto change = case_file::change_of;
  const Truth truths[] = {{.name = "start-3d-paper", .corner_mm = 39.0, .uncertainty_mm = 0.4},
                          {.name = "start-3d-paper",
                           .changes = {change("schedule.water_flow.scale", "0.5")},
                           .corner_mm = 36.6,
                           .uncertainty_mm = 0.4},
                          {.name = "start-3d-paper",
                           .changes = {change("schedule.casting_speed.scale", "0.7")},
                           .corner_mm = 26.9,
                           .uncertainty_mm = 0.5},
                          {.name = "start-3d-aa1050", .corner_mm = 27.7, .uncertainty_mm = 0.8},
                          {.name = "start-3d-aa3104", .corner_mm = 37.0, .uncertainty_mm = 0.8},
                          {.name = "start-3d-aa3104",
                           .changes = {change("schedule.casting_temperature.offset", "20 K")},
                           .corner_mm = 38.5,
                           .uncertainty_mm = 1.0},
                          {.name = "start-3d-aa3104",
                           .changes = {change("section.block_above_water", "30 mm")},
                           .corner_mm = 36.5,
                           .uncertainty_mm = 0.5},
                          {.name = "start-3d-aa6063", .corner_mm = 34.5, .uncertainty_mm = 0.7},
                          {.name = "start-3d-aa5182", .corner_mm = 42.2, .uncertainty_mm = 1.2}};

  for (const Truth& truth : truths)
    for (const v1::Quality quality : {v1::DRAFT, v1::ENGINEERING}) {
      const double lift = corner_mm(truth, quality);
      const v1::RelativeError error = band(truth, quality);
      EXPECT_LE(lift * (1.0 - error.lower()), truth.corner_mm - truth.uncertainty_mm) << truth.name;
      EXPECT_GE(lift * (1.0 + error.upper()), truth.corner_mm + truth.uncertainty_mm) << truth.name;
    }
}

}  // namespace
}  // namespace dccast
