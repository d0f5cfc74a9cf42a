#include "core/findings/of_step.hpp"
#include "core/findings/sentence.hpp"

namespace dccast::casting {

namespace {

constexpr const char* code = "curl_outside_band";

Finding above(const StepFigures& f, double limit) {
  return finding_of(code, Severity::warning,
                    sentence("The curl is %.4g mm, above the %.4g mm that the plant "
                             "accepts: the butt rocks on the block, and more of it is sawn off.",
                             in_mm * f.greatest_curl, in_mm * limit),
                    {{f.greatest_curl}, limit, "m", "plausibility.greatest_curl"});
}

Finding below(const StepFigures& f, double limit) {
  return finding_of(code, Severity::warning,
                    sentence("The final curl is %.4g mm, below the %.4g mm that the plant accepts: "
                             "the recipe misses its aim.",
                             in_mm * f.greatest_curl, in_mm * limit),
                    {{f.greatest_curl}, limit, "m", "plausibility.least_curl"});
}

}  // namespace

/// The upper edge holds at any time, the lower one at the end.
std::optional<Finding> curl_outside_band(const Case& c, const StepFigures& f) {
  const auto& greatest = c.plausibility.greatest_curl;
  const auto& least = c.plausibility.least_curl;
  if (!f.mechanical) return std::nullopt;
  if (greatest && f.greatest_curl > *greatest) return above(f, *greatest);
  if (least && f.last && f.greatest_curl < *least) return below(f, *least);
  return std::nullopt;
}

}  // namespace dccast::casting
