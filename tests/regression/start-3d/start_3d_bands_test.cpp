#include <algorithm>
#include <map>
#include <string>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/slab_recipe.hpp"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

constexpr double settled = 1200.0;  // [s]

/// A curl that is known on finer meshes and steps (docs/error-bars.md).
struct Truth {
  const char* casting;
  double time_s;
  const char* monitor;
  double curl_mm, uncertainty_mm;
};

constexpr const char* corner = "corner";
constexpr const char* narrow_face = "middle of the narrow face";

const Truth truths[] = {
    {"start-3d-paper", 250.0, corner, 37.0, 0.5},
    {"start-3d", 250.0, corner, 38.9, 0.5},
    {"start-3d", 250.0, narrow_face, 38.4, 0.5},
    {"start-3d", settled, corner, 55.8, 0.7},
    {"start-3d", settled, narrow_face, 53.2, 0.7},
    {"start-3d-aa1050", 250.0, corner, 27.8, 0.4},
    {"start-3d-aa1050", 250.0, narrow_face, 25.3, 0.4},
    {"start-3d-aa1050", settled, corner, 37.1, 0.5},
    {"start-3d-aa1050", settled, narrow_face, 33.1, 0.4},
    {"start-3d-aa3104", 250.0, corner, 35.3, 0.5},
    {"start-3d-aa3104", 250.0, narrow_face, 33.6, 0.5},
    {"start-3d-aa3104", settled, corner, 45.3, 0.6},
    {"start-3d-aa3104", settled, narrow_face, 42.2, 0.6},
    {"start-3d-aa5182", 250.0, corner, 40.5, 0.6},
    {"start-3d-aa5182", 250.0, narrow_face, 39.7, 0.6},
    {"start-3d-aa5182", settled, corner, 55.0, 0.8},
    {"start-3d-aa5182", settled, narrow_face, 52.3, 0.8},
    {"start-3d-aa6063", 250.0, corner, 32.2, 0.5},
    {"start-3d-aa6063", 250.0, narrow_face, 30.1, 0.4},
    {"start-3d-aa6063", settled, corner, 41.4, 0.6},
    {"start-3d-aa6063", settled, narrow_face, 38.1, 0.5},
    {"1000x450mm aa1050", settled, corner, 22.0, 0.3},
    {"1000x450mm aa1050", settled, narrow_face, 19.7, 0.2},
    {"1000x450mm aa3104", settled, corner, 27.5, 0.4},
    {"1000x450mm aa3104", settled, narrow_face, 25.7, 0.3},
    {"1000x450mm aa5182", settled, corner, 33.2, 0.5},
    {"1000x450mm aa5182", settled, narrow_face, 31.3, 0.4},
    {"1600x500mm aa1050", settled, corner, 47.0, 0.6},
    {"1600x500mm aa1050", settled, narrow_face, 44.0, 0.6},
    {"1600x500mm aa3104", settled, corner, 61.2, 0.8},
    {"1600x500mm aa3104", settled, narrow_face, 59.1, 0.8},
    {"1600x500mm aa5182", settled, corner, 77.2, 1.1},
    {"1600x500mm aa5182", settled, narrow_face, 75.3, 1.1},
    {"2200x600mm aa3104", settled, corner, 103.8, 1.5},
    {"2200x600mm aa3104", settled, narrow_face, 100.7, 1.4},
};

using Reports = std::vector<results::StepReport>;

/// Text of a shipped start, or of that which `dccast new` writes for "1600x500mm aa3104".
std::string text_of(const std::string& name) {
  if (const auto* shipped = shipped::find(shipped::case_templates(), name)) return shipped->text;
  const auto space = name.find(' ');
  const case_file::SlabRecipe recipe{
      .slab = name.substr(0, space), .alloy = name.substr(space + 1), .speed = {}, .water = {}};
  return case_file::new_case(recipe).text;
}

/// A start at a quality, computed once for all its truths.
class QualityRun {
public:
  QualityRun(const std::string& name, v1::Quality quality) {
    case_file::read_text(text_of(name), name, case_);
    case_.set_quality(quality);
    case_file::apply_defaults(case_);
    reports_ = regression::run(support::complete_case(case_));
  }

  v1::RelativeError band(const std::string& monitor) const {
    return case_file::monitor_error(case_, monitor).value();
  }

  /// At an instant, or at the end of a casting that has settled before [mm].
  double curl_mm(const std::string& name, double time_s) const {
    const auto monitor = std::ranges::find(case_.monitor(), name, &v1::Monitor::name);
    Reports until = reports_;
    std::erase_if(until, [&](const auto& report) { return report.time > time_s + 1e-6; });
    return regression::end_lift_mm(until, std::size_t(monitor - case_.monitor().begin()));
  }

private:
  v1::Case case_;
  Reports reports_;
};

TEST(Start3dBands, HoldTheTruths) {
  for (const v1::Quality quality : {v1::DRAFT, v1::ENGINEERING}) {
    std::map<std::string, QualityRun> runs;
    for (const Truth& truth : truths) {
      const QualityRun& run = runs.try_emplace(truth.casting, truth.casting, quality).first->second;
      const double curl = run.curl_mm(truth.monitor, truth.time_s);
      const v1::RelativeError error = run.band(truth.monitor);
      EXPECT_LE(curl * (1.0 - error.lower()), truth.curl_mm - truth.uncertainty_mm)
          << truth.casting << ' ' << truth.monitor << ' ' << truth.time_s;
      EXPECT_GE(curl * (1.0 + error.upper()), truth.curl_mm + truth.uncertainty_mm)
          << truth.casting << ' ' << truth.monitor << ' ' << truth.time_s;
    }
  }
}

}  // namespace
}  // namespace dccast
