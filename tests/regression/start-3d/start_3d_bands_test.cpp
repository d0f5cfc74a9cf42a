#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

double corner_mm(const std::string& name, v1::Quality quality) {
  return regression::end_lift_mm(regression::run(support::load_case(name, quality)), 0);
}

v1::RelativeError band(const std::string& name, v1::Quality quality) {
  v1::Case description;
  for (const auto& shipped : shipped::case_templates())
    if (shipped.name == name) case_file::read_text(shipped.text, name, description);
  description.set_quality(quality);
  case_file::apply_defaults(description);
  return case_file::relative_discretisation_error(description).value();
}

/// The bands were made from start-3d-paper, whose fine lift is 3 % below the converged one.
TEST(Start3dBands, HoldTheTruthOfCastingsTheyWereNotMadeFrom) {
  constexpr double fine_to_converged = 1.03;
  int checks = 0, held = 0;
  for (const char* name :
       {"start-3d-aa1050", "start-3d-aa3104", "start-3d-aa5182", "start-3d-aa6063"}) {
    const double truth = fine_to_converged * corner_mm(name, v1::FINE);
    for (const v1::Quality quality : {v1::DRAFT, v1::ENGINEERING}) {
      const double lift = corner_mm(name, quality);
      RecordProperty(std::string(name) + (quality == v1::DRAFT ? "-draft" : "-engineering"),
                     std::to_string(lift) + " of " + std::to_string(truth));
      ++checks;
      const v1::RelativeError error = band(name, quality);
      if (truth >= lift * (1.0 - error.lower()) && truth <= lift * (1.0 + error.upper())) ++held;
    }
  }
  EXPECT_GE(10 * held, 9 * checks) << held << " of " << checks;
}

}  // namespace
}  // namespace dccast
