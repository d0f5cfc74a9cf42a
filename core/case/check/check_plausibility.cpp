#include "core/case/check/checks.hpp"

namespace dccast::casting {

void check_plausibility(CaseFindings& found) {
  const std::optional<double>& least = found.casting.plausibility.least_curl;
  const std::optional<double>& greatest = found.casting.plausibility.greatest_curl;
  if (!found.sound({"plausibility.least_curl", "plausibility.greatest_curl"})) return;
  if (!least || !greatest || *least < *greatest) return;
  found.fault("plausibility.greatest_curl", with_unit(*greatest, "m"),
              "does not lie above the lower edge of the band",
              "more than plausibility.least_curl = " + with_unit(*least, "m"),
              "exchange the two, or leave one out");
}

}  // namespace dccast::casting
