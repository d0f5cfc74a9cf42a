#include "core/thermal/gap_water.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/thermal/heat_solver.hpp"
#include "tests/unit/thermal/casting_case.hpp"

namespace dccast::thermal {
namespace {

constexpr GapWater gap_water{
    .inflow_share = 0.4, .touching_share = 0.5, .block_coefficient = 2000.0, .steam_reach = 0.5};

/// The water of the faces, which reaches far into the gap.
Water law() {
  Water w = testing::water();
  w.temperature = Curve(25.0);
  w.boiling_follows_flow = true;
  w.wetting = testing::wetting();
  w.wetting.throw_off_length = gap_water.steam_reach;
  return w;
}

/// A butt 0.28 m wide in 8 places, 1 m deep; its edge is the last place.
constexpr std::size_t places = 8;
constexpr double spacing = 0.04;

std::vector<BottomPath> chain() {
  std::vector<BottomPath> paths;
  for (std::size_t i = 0; i + 1 < places; ++i) paths.push_back({i, i + 1, spacing});
  return paths;
}

std::vector<GapSurface> open_butt(double temperature, double wetted) {
  const GapSurface place{.area = spacing,
                         .gap = 5e-3,
                         .open = 1.0,
                         .temperature = temperature,
                         .wetted = wetted,
                         .block = {.block = 200.0, .compliance = 3e-4}};
  return std::vector<GapSurface>(places, place);
}

GapStreams run(const std::vector<GapSurface>& butt, double flow, double time_step = 1.0,
               std::span<const GapHole> holes = {}) {
  const std::vector<EdgeSupply> supply{{places - 1, {40.0, flow}, 1.0}};
  return lay_gap_water(gap_water, law(), chain(), butt, supply, holes, 0.0, time_step);
}

/// A hole at a place of the butt that takes up a part of its depth of 1 m. @param across  [m]
std::vector<GapHole> hole_at(std::size_t place, double across, GapPassage passage = {1.0}) {
  return {{.nodes = {{place, 0.0}}, .across = across, .passage = passage}};
}

/// Water comes from the edge: a closed gap keeps it from all that lies behind.
TEST(GapRoutes, LeadThroughTheOpenGapOnly) {
  const std::vector<GapOpening> edge{{places - 1, 3, 0.0}};
  std::vector<char> open(places, 1);
  open[2] = 0;
  const auto route = find_gap_routes(places, chain(), edge, open);
  EXPECT_FALSE(route[0]);
  EXPECT_FALSE(route[2]);
  ASSERT_TRUE(route[3]);
  EXPECT_NEAR(route[3]->distance, 4.0 * spacing, 1e-12);
  EXPECT_EQ(route[3]->opening, 3u);

  open.back() = 0;
  for (const auto& none : find_gap_routes(places, chain(), edge, open)) EXPECT_FALSE(none);
}

TEST(GapRoutes, TakeTheShorterWay) {
  const std::vector<BottomPath> square{{0, 1, 1.0}, {1, 2, 1.0}, {0, 2, std::sqrt(2.0)}};
  const std::vector<GapOpening> edge{{2, 0, 0.0}};
  const auto route = find_gap_routes(3, square, edge, {1, 1, 1});
  EXPECT_DOUBLE_EQ(route[0]->distance, std::sqrt(2.0));
}

/// All that slab and block may give off in a step is what the water that gets in can take.
TEST(GapWater, NeverOffersMoreThanItsCapacity) {
  for (const double flow : {1e-4, 1e-3, 3e-3}) {
    const auto butt = open_butt(300.0, 1.0);
    const GapStreams streams = run(butt, flow);
    const double capacity = gap_water.inflow_share * film_capacity({40.0, flow}, 1.0);
    EXPECT_NEAR(streams.water.capacity, capacity, 1e-9 * capacity);

    double most = 0.0;
    for (std::size_t i = 0; i < places; ++i) {
      const GapPlace& at = streams.place[i];
      if (at.share > 0.0) most += butt[i].area * (at.share * at.water.largest_flux + at.block_flux);
    }
    EXPECT_LE(most, capacity * (1.0 + 1e-12)) << flow;
    EXPECT_GT(most, 0.5 * capacity) << flow;
  }
}

/// The film warms from the edge inwards by the heat of slab and block.
TEST(GapWater, WarmsByTheHeatThatItTakes) {
  const auto butt = open_butt(110.0, 1.0);
  const GapStreams streams = run(butt, 3e-3, 1e-3);
  double heat = 0.0;  // [W] up to the innermost place
  for (std::size_t i = 1; i < places; ++i) {
    const GapPlace& at = streams.place[i];
    heat += butt[i].area * at.share * water_flux(law(), at.water, {110.0, 0.0}, {}).flux;
    heat += butt[i].area * at.block_flux;
  }
  const double mass = gap_water.inflow_share * 3e-3 * water_density;  // [kg/s]
  const double gained =
      mass * water_specific_heat * (streams.place[0].water.film.temperature - 40.0);
  EXPECT_NEAR(heat, gained, 1e-3 * gained);
}

/// A butt that it does not wet stays dry beyond the reach of the water.
TEST(GapWater, SteamKeepsItOutOfAHotGap) {
  Water short_reach = law();
  short_reach.wetting.throw_off_length = 0.1;
  const auto butt = open_butt(600.0, 0.0);
  const std::vector<EdgeSupply> supply{{places - 1, {40.0, 5e-4}, 1.0}};
  const GapStreams streams =
      lay_gap_water(gap_water, short_reach, chain(), butt, supply, {}, 0.0, 1.0);
  EXPECT_TRUE(streams.water.thrown_off);
  EXPECT_GT(streams.place[places - 1].share, 0.0);
  EXPECT_EQ(streams.place[0].share, 0.0);
}

TEST(GapWater, WithoutSupplyIsDry) {
  const GapStreams streams = run(open_butt(300.0, 1.0), 0.0);
  for (const GapPlace& place : streams.place) EXPECT_EQ(place.share, 0.0);
  EXPECT_EQ(streams.water.capacity, 0.0);
}

/// Two columns of water at a corner: mass and heat add up.
TEST(GapWater, JoinsWhatComesDownAtOnePlace) {
  const auto butt = open_butt(100.0, 1.0);
  const std::vector<EdgeSupply> two{{places - 1, {30.0, 1e-3}, 0.5},
                                    {places - 1, {60.0, 3e-3}, 0.5}};
  const std::vector<EdgeSupply> mixed{{places - 1, {52.5, 2e-3}, 1.0}};
  const auto joined = lay_gap_water(gap_water, law(), chain(), butt, two, {}, 0.0, 1.0);
  const auto same = lay_gap_water(gap_water, law(), chain(), butt, mixed, {}, 0.0, 1.0);
  EXPECT_NEAR(joined.water.capacity, same.water.capacity, 1e-9 * same.water.capacity);
  EXPECT_NEAR(joined.place[0].water.film.temperature, same.place[0].water.film.temperature, 1e-9);
}

/// Slow steam from one place: plane Poiseuille flow, 12 mu m L / (rho g^3), and one velocity head.
TEST(Steam, LosesThePressureOfAPlaneChannel) {
  const double gap = 1e-3, length = 0.2, flow = 5e-3;  // [m], [m], [kg/s per m]
  const std::vector<GapPiece> pieces{{0.01, 0.0, gap}, {0.01, length, gap}, {0.01, 0.3, gap}};
  const std::vector<double> steam{0.0, flow};
  const auto pressure = steam_pressure(pieces, steam, {1.0});
  const double velocity = flow / (0.598 * gap);
  const double head = 0.5 * 0.598 * velocity * velocity;
  EXPECT_NEAR(pressure[0], head, 1e-9 * head);
  const double expected = head + 12.0 * 1.2e-5 * flow * length / (0.598 * gap * gap * gap);
  EXPECT_NEAR(pressure[1], expected, 1e-9 * expected);
  EXPECT_EQ(pressure[2], pressure[1]) << "nothing flows behind the last wet place";
}

/// Half the gap: fourfold the velocity head, eightfold the friction.
TEST(Steam, RisesSteeplyInANarrowGap) {
  const std::vector<double> steam{0.01, 0.01};
  const auto last = [&](double gap) {
    const std::vector<GapPiece> pieces{{0.01, 0.0, gap}, {0.01, 0.2, gap}};
    return steam_pressure(pieces, steam, {1.0}).back();
  };
  EXPECT_GT(last(1e-3), 4.0 * last(2e-3));
  EXPECT_LT(last(1e-3), 8.0 * last(2e-3));
}

/// Slow steam that flows to a hole from all sides: 12 mu m / (angle rho g^3) ln((r + s) / r), and
/// the velocity head at the rim.
TEST(Steam, FlowsRadiallyToAHole) {
  const double gap = 1e-3, radius = 0.02, reach = 0.3, flow = 1e-3;  // [m], [m], [m], [kg/s]
  const double angle = 0.5 * std::numbers::pi;
  const std::vector<GapPiece> pieces{{0.01, 0.0, gap}, {0.01, 0.1, gap}, {0.01, reach, gap}};
  const std::vector<double> steam{0.0, 0.0, flow};
  const auto pressure = steam_pressure(pieces, steam, {angle * radius, angle});

  const double velocity = flow / (0.598 * gap * angle * radius);
  const double head = 0.5 * 0.598 * velocity * velocity;
  const double friction = 12.0 * 1.2e-5 * flow / (angle * 0.598 * gap * gap * gap) *
                          std::log((radius + reach) / radius);
  EXPECT_NEAR(pressure.back(), head + friction, 1e-9 * friction);
}

/// Steam in the middle of a butt whose edge is 0.28 m away gets out through a hole 0.08 m away: its
/// pressure is that of the shorter way.
TEST(DrainHoles, LowerTheSteamPressureToThatOfTheShorterWay) {
  std::vector<GapSurface> butt = open_butt(300.0, 1.0);
  for (GapSurface& place : butt) place.gap = 1e-3;
  butt[0].open = 1e-9;  // the innermost place gives off nothing

  // This hole takes no water, so that the same steam is given off.
  const auto closed = run(butt, 1e-3), drained = run(butt, 1e-3, 1.0, hole_at(2, 0.0));
  ASSERT_GT(drained.place[0].share, 0.0) << "the water gets to the end";

  // Up to half-way steam flows to the hole, from there on to the edge.
  const auto given_off = [&](std::size_t i) {
    const double left = drained.place[i > 0 ? i - 1 : 0].water.film.flow;
    return water_density * gap_water.touching_share * (drained.place[i].water.film.flow - left);
  };
  const auto pressure = [&](std::initializer_list<std::size_t> way) {
    std::vector<GapPiece> pieces;
    std::vector<double> steam;
    for (const std::size_t i : way) {
      const double distance = spacing * std::abs(double(i) - double(*way.begin()));
      pieces.push_back({spacing, distance, 1e-3});
      steam.push_back(given_off(i));
    }
    return steam_pressure(pieces, steam, {1.0}).back();
  };
  const double without = pressure({7, 6, 5, 4, 3, 2, 1, 0});
  EXPECT_NEAR(closed.steam_pressure, without, 1e-6 * without);

  const double with = std::max(pressure({7, 6, 5}), pressure({2, 1, 3, 0, 4}));
  EXPECT_NEAR(drained.steam_pressure, with, 1e-6 * with);
  EXPECT_LT(with, 0.5 * without);
  EXPECT_LT(drained.steam_force, 0.5 * closed.steam_force);
}

/// A hole across a quarter of the stream takes a quarter of its water; what runs on is the rest.
TEST(DrainHoles, TakeTheirShareOfTheStream) {
  const auto butt = open_butt(40.0, 1.0);
  std::vector<GapSurface> cold = butt;  // as the water is: it neither warms nor evaporates
  for (GapSurface& place : cold) place.block.block = 40.0;
  const GapStreams streams = run(cold, 2e-3, 1.0, hole_at(4, 0.25));
  const double entering = streams.place[places - 1].water.film.flow;
  EXPECT_DOUBLE_EQ(streams.place[4].water.film.flow, entering) << "water reaches the hole";
  EXPECT_DOUBLE_EQ(streams.place[3].water.film.flow, 0.75 * entering);
  EXPECT_DOUBLE_EQ(streams.place[0].water.film.flow, 0.75 * entering);

  // A hole as wide as the stream leaves the gap behind it dry.
  const GapStreams all = run(cold, 2e-3, 1.0, hole_at(4, 1.5));
  EXPECT_GT(all.place[4].share, 0.0);
  EXPECT_EQ(all.place[3].share, 0.0);
  EXPECT_FALSE(all.water.boiled_away);
}

/// What slab and block may take before and behind the hole together is what the water can take.
TEST(DrainHoles, LeaveTheWaterWithinItsCapacity) {
  const auto butt = open_butt(300.0, 1.0);
  for (const double across : {0.0, 0.3, 0.9}) {
    const GapStreams streams = run(butt, 2e-3, 1.0, hole_at(5, across));
    double most = 0.0;
    for (std::size_t i = 0; i < places; ++i) {
      const GapPlace& at = streams.place[i];
      if (at.share > 0.0) most += butt[i].area * (at.share * at.water.largest_flux + at.block_flux);
    }
    EXPECT_LE(most, streams.water.capacity * (1.0 + 1e-12)) << across;
    EXPECT_GT(most, 0.5 * streams.water.capacity) << across;
  }
}

/// A closed gap over the hole lets nothing out.
TEST(DrainHoles, NeedAnOpenGap) {
  auto butt = open_butt(300.0, 1.0);
  butt[0].open = 0.0;
  const auto without = run(butt, 1e-3), with = run(butt, 1e-3, 1.0, hole_at(0, 1.0));
  EXPECT_EQ(with.steam_force, without.steam_force);
  EXPECT_EQ(with.place[1].water.film.flow, without.place[1].water.film.flow);
}

TEST(DrainHoles, LieOverTheNodesWithinTheirRim) {
  const std::vector<std::array<double, 2>> nodes{{0.0, 0.0}, {0.1, 0.0}, {0.2, 0.0}, {0.1, 0.1}};
  const std::vector<DrainHole> holes{{0.0, 0.0, 0.05}, {0.13, 0.0, 0.04}, {0.15, 0.05, 0.2}};
  const auto found = find_gap_holes(holes, nodes);

  // In the middle of the block a quarter of the hole lies in the quarter slab.
  ASSERT_EQ(found[0].nodes.size(), 1u);
  EXPECT_EQ(found[0].nodes[0].number, 0u);
  EXPECT_DOUBLE_EQ(found[0].passage.spread, 0.5 * std::numbers::pi);
  EXPECT_DOUBLE_EQ(found[0].across, 0.025);

  // Between two nodes: the nearest one, 10 mm from the rim of half a hole.
  ASSERT_EQ(found[1].nodes.size(), 1u);
  EXPECT_EQ(found[1].nodes[0].number, 1u);
  EXPECT_NEAR(found[1].nodes[0].distance, 0.01, 1e-12);
  EXPECT_DOUBLE_EQ(found[1].passage.width, std::numbers::pi * 0.02);

  EXPECT_EQ(found[2].nodes.size(), 3u);
  EXPECT_DOUBLE_EQ(found[2].across, 0.2);
}

/// A section with a body of a block, whose gap opens to the edge.
struct Butt {
  /// @param wiped_at  [m] below the metal level, where a wiper takes the water off the face
  explicit Butt(std::optional<double> wiped_at = std::nullopt)
      : slab(testing::casting_section(mesh::ElementKind::q1)), solver(make(wiped_at)) {
    field = solver.uniform_field(640.0);
    gap.assign(solver.forms().bottom_nodes().size(), 8e-3);
  }
  HeatSolver make(std::optional<double> wiped_at) const {
    CoolingSpec cooling = testing::casting_cooling();
    cooling.top = Top::insulated;
    cooling.water = law();
    cooling.water.wetting.throw_off_length = 0.04;
    cooling.water.wiped_at = wiped_at;
    cooling.bottom_block.body = aluminium;
    cooling.bottom_block.wet_gap = 3e-3;
    cooling.bottom_block.gap_water = gap_water;
    return HeatSolver(material::ThermalProperties(testing::casting_alloy()), cooling,
                      make_heat_forms(slab.mesh(), mesh::SectionKind::plane_strain));
  }
  HeatStepOutcome step(double time) {
    HeatStepInput input;
    input.time = time;
    input.time_step = 1.0;
    input.metal_level = 0.1;
    input.casting_temperature = 640.0;
    input.water_flow = 2e-3;
    input.bottom_gap = gap;
    return solver.step(field, input);
  }
  double block_heat() const {
    const BlockColumns block(aluminium);
    double sum = 0.0;
    for (std::size_t i = 0; i < gap.size(); ++i)
      sum += solver.forms().bottom_weight()[i] *
             block.heat(std::span(field.block_temperature)
                            .subspan(i * BlockColumns::points, BlockColumns::points));
    return sum;
  }

  static constexpr BlockBody aluminium{
      .thickness = 0.15, .conductivity = 170.0, .heat_capacity = 2.6e6};
  mesh::SlabMesh2D slab;
  HeatSolver solver;
  HeatField field;
  std::vector<double> gap;
};

/// Slab, block and water exchange what each gains and loses, and the water takes no more than it
/// can.
TEST(GapWater, HeatAddsUpInARun) {
  Butt butt;
  double lost = 0.0, taken = 0.0;
  const double before = 80.0 * 2.6e6 * 0.15 * 0.28;
  for (int k = 1; k <= 30; ++k) {
    const HeatStepOutcome outcome = butt.step(k);
    ASSERT_TRUE(outcome.converged);
    EXPECT_LT(outcome.balance.error, 1e-10);
    EXPECT_LE(outcome.gap_water.share(), 1.0);
    EXPECT_GT(outcome.gap_water.taken, 0.0);
    lost += outcome.balance.bottom;
    taken += outcome.gap_water.taken;
  }
  EXPECT_NEAR(lost, butt.block_heat() - before + taken, 1e-10 * (lost + taken));
}

/// The same butt with its edge on the block stays dry: the heat goes into the block.
TEST(GapWater, NeedsAnOpenEdge) {
  Butt butt;
  const auto& nodes = butt.solver.forms().bottom_nodes();
  for (std::size_t i = 0; i < nodes.size(); ++i)
    if (butt.slab.mesh().point(nodes[i])[0] > 0.25) butt.gap[i] = 0.0;
  const HeatStepOutcome outcome = butt.step(1.0);
  EXPECT_EQ(outcome.gap_water.taken, 0.0);
  EXPECT_EQ(outcome.steam_force, 0.0);
}

/// Below the wiper the face is dry, so that it gives off less heat, and no water comes down to the
/// edge.
TEST(GapWater, DoesNotComeWhereAWiperTakesItOffTheFace) {
  Butt wet, wiped(0.08);
  double wet_heat = 0.0, wiped_heat = 0.0;
  for (int k = 1; k <= 10; ++k) {
    const HeatStepOutcome with = wet.step(k), without = wiped.step(k);
    EXPECT_GT(with.gap_water.taken, 0.0);
    EXPECT_EQ(without.gap_water.taken, 0.0);
    EXPECT_LT(without.balance.error, 1e-10);
    wet_heat += with.balance.side;
    wiped_heat += without.balance.side;
  }
  EXPECT_LT(wiped_heat, 0.8 * wet_heat);

  // A wiper below the butt changes nothing.
  Butt below(0.2), same;
  EXPECT_EQ(below.step(1.0).gap_water.taken, same.step(1.0).gap_water.taken);
}

}  // namespace
}  // namespace dccast::thermal
