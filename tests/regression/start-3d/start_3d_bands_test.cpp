#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

/// A casting whose corner at 250 s is known on finer meshes (docs/error-bars.md).
struct Truth {
  const char* name;
  double corner_mm, uncertainty_mm;
};

v1::Case description_of(const Truth& casting, v1::Quality quality) {
  v1::Case description;
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == casting.name) case_file::read_text(shipped.text, casting.name, description);
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
  const Truth truths[] = {{.name = "start-3d-paper", .corner_mm = 37.0, .uncertainty_mm = 0.5},
                          {.name = "start-3d", .corner_mm = 38.9, .uncertainty_mm = 0.5},
                          {.name = "start-3d-aa1050", .corner_mm = 27.8, .uncertainty_mm = 0.4},
                          {.name = "start-3d-aa3104", .corner_mm = 35.3, .uncertainty_mm = 0.5},
                          {.name = "start-3d-aa6063", .corner_mm = 32.2, .uncertainty_mm = 0.5},
                          {.name = "start-3d-aa5182", .corner_mm = 40.5, .uncertainty_mm = 0.6}};

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
