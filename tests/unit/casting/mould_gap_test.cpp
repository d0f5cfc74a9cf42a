// Castings whose faces lose contact with the mould as they shrink.
#include <gtest/gtest.h>

#include <cmath>

#include "core/casting/simulation.hpp"
#include "tests/unit/casting/small_casting.hpp"

namespace dccast::casting {
namespace {

using testing::Recorder;
using testing::small_casting;

/// The contact of the whole mould is good, so that the gap alone decides.
Case in_good_contact() {
  Case c = small_casting(mesh::ElementKind::q1_bending);
  for (thermal::SideZone& zone : c.cooling.zones)
    zone.liquid_coefficient = zone.solid_coefficient = Curve(2000.0);
  return c;
}

void follow_gap(Case& c, double taper) {
  for (thermal::SideZone& zone : c.cooling.zones)
    zone.gap = thermal::MouldGap{.air_conductivity = 0.05, .emissivity = 0.3, .taper = taper};
}

/// Heat of the side from the first water on [J/m], with the balance of every step.
double side_heat(const Case& c) {
  const TemporaryFolder folder;
  Recorder recorder;
  EXPECT_TRUE(check(c).faults.empty()) << testing::all(check(c).faults);
  EXPECT_EQ(run(c, {folder / "", false}, recorder).end, RunEnd::succeeded);

  double sum = 0.0;
  for (const auto& r : recorder.reports) {
    EXPECT_LE(std::abs(r.energy_balance_error), 1e-9) << "t = " << r.time;
    if (r.time > 0.0) sum += r.side_heat * r.time_step;
  }
  return sum;
}

/// The face shrinks away from the mould and loses contact; a mould that closes in keeps some of it.
TEST(MouldGap, TakesHeatByTheGapThatTheMechanicsComputed) {
  const double contact = side_heat(in_good_contact());

  Case gap = in_good_contact();
  follow_gap(gap, 0.0);
  const double with_gap = side_heat(gap);

  Case tapered = in_good_contact();
  follow_gap(tapered, 0.4);
  const double with_taper = side_heat(tapered);

  // The thin shell turns away from the mould while it is hot; a mould that closes in as fast keeps
  // most of the contact.
  EXPECT_LT(with_gap, 0.85 * contact);
  EXPECT_GT(with_taper, 0.92 * contact);
  EXPECT_LT(with_taper, contact);
}

}  // namespace
}  // namespace dccast::casting
