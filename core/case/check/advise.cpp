#include "core/case/check/checks.hpp"

namespace dccast::casting {

void advise(CaseFindings& found) {
  if (found.casting.monitors.empty()) {
    found.warning("monitor", "", "there is no monitor: no displacement will be reported", "",
                  "add a [[monitor]] table");
  }
  if (found.casting.mechanics.enabled && found.sound({"mechanics.start", "time.end"}) &&
      found.casting.mechanics.start > found.casting.time.end) {
    found.warning("mechanics.start", with_unit(found.casting.mechanics.start, "s"),
                  "lies after the end: the mechanics never starts");
  }
}

}  // namespace dccast::casting
