#include "dccast/v1/case.pb.h"
#include "tests/regression/start-3d/sound_casting.hpp"
#include "tests/support/load_case.hpp"

namespace dccast {
namespace {

using regression::end_lift_mm;

TEST(Start3d, StaysInBalanceAsShippedAndDraftLiesWithinItsBand) {
  const auto shipped = regression::run(support::load_case("start-3d"));
  regression::expect_sound_casting(shipped);
  const auto draft = regression::run(support::load_case("start-3d", v1::DRAFT));
  EXPECT_NEAR(end_lift_mm(draft, 0), end_lift_mm(shipped, 0), 0.09 * end_lift_mm(shipped, 0));
}

}  // namespace
}  // namespace dccast
