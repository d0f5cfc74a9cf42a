#include "core/casting/findings/hot_tears.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "core/casting/findings/pores.hpp"
#include "core/material/thermal_properties.hpp"
#include "core/mesh/plan_transfer.hpp"
#include "core/mesh/slab_mesh.hpp"
#include "tests/unit/material/mush_card.hpp"

namespace dccast::casting {
namespace {

/// Freezes linearly between 649 and 620 degC; 90 % solid at 622.9, 98 % at 620.58 degC.
material::AlloyCard windowed_card() {
  material::AlloyCard card = material::testing::mush_card();
  card.hot_tears = {.start = 0.9, .end = 0.98, .arm_spacing = 80e-6};
  return card;
}

// ---- The pressure drop of the feeding melt, where gradient, velocity and strain rate are constant

constexpr double liquidus = 649.0, width = 29.0;  // [°C], [K]
constexpr double gradient = 2000.0;               // [K/m]
constexpr double velocity = 1.5e-3;               // [m/s] of the isotherms
constexpr double rate = 2e-4;                     // [1/s]

/// Takes a place from the liquidus to a temperature in steps of equal length.
MushFeeding::Path passage(const MushFeeding& feeding, double to, int steps, double strain_rate) {
  MushFeeding::Path path;
  const double fall = (liquidus - to) / steps;
  for (int i = 0; i < steps; ++i)
    feeding.advance(path, {.from = liquidus - i * fall,
                           .to = liquidus - (i + 1) * fall,
                           .time = fall / (gradient * velocity),
                           .gradient = gradient,
                           .strain_rate = strain_rate});
  return path;
}

/// 180 mu / lambda^2 of the card.
constexpr double scale = 180.0 * 1e-3 / (80e-6 * 80e-6);

/// Closed form of the shrinkage term: int fs^2 / (1 - fs)^2 dfs = fs + 2 ln(1 - fs) + 1 / (1 - fs).
TEST(MushFeeding, ShrinkageAloneIsTheClosedForm) {
  const MushFeeding feeding(windowed_card());
  const double integral = 0.98 + 2.0 * std::log(0.02) + 1.0 / 0.02 - 1.0;
  const double exact = scale * 0.06 * velocity / gradient * width * integral;
  for (const int steps : {1, 7, 400})
    EXPECT_NEAR(feeding.pressure_drop(passage(feeding, 610.0, steps, 0.0)), exact, 1e-4 * exact)
        << steps << " steps: the way behind the window adds nothing";
}

/// The form that was published: E grows from the end of the window towards the melt, and is
/// integrated there.
TEST(MushFeeding, StrainIsFedThroughTheWholeMushBeforeIt) {
  const MushFeeding feeding(windowed_card());

  constexpr int parts = 400000;
  constexpr double step = 0.98 / parts;  // of the solid fraction
  double strained = 0.0, integral = 0.0;
  for (int i = parts; i-- > 0;) {
    const double fs = (i + 0.5) * step;
    const double middle = strained + 0.5 * fs * rate * width * step / gradient;  // E [m/s]
    strained += fs * rate * width * step / gradient;
    integral += middle * fs * fs / std::pow(1.0 - fs, 3) * width * step / gradient;
  }
  const double exact = scale * 1.06 * integral;

  const double shrinkage = feeding.pressure_drop(passage(feeding, 610.0, 1, 0.0));
  for (const int steps : {1, 7, 400}) {
    const double whole = feeding.pressure_drop(passage(feeding, 610.0, steps, rate));
    EXPECT_NEAR(whole - shrinkage, exact, 1e-4 * exact) << steps << " steps";
  }
}

TEST(MushFeeding, MetalThatWarmsUpGoesBackAndAtTheLiquidusBeginsAnew) {
  const MushFeeding feeding(windowed_card());
  MushFeeding::Path path = passage(feeding, 621.0, 3, rate);
  const double there = feeding.pressure_drop(path);
  const MushFeeding::Step cooling{621.0, 620.7, 0.1, gradient, rate};
  const MushFeeding::Step warming{620.7, 621.0, 0.1, gradient, rate};
  feeding.advance(path, cooling);
  EXPECT_GT(feeding.pressure_drop(path), there);
  feeding.advance(path, warming);
  EXPECT_NEAR(feeding.pressure_drop(path), there, 1e-9 * there);

  feeding.advance(path, {621.0, 650.0, 1.0, gradient, rate});
  EXPECT_EQ(feeding.pressure_drop(path), 0.0);
}

TEST(MushFeeding, MetalThatFreezesAtOneTemperatureHasNoMush) {
  material::AlloyCard card = windowed_card();
  card.solidus = card.liquidus;
  const MushFeeding feeding(card);
  EXPECT_FALSE(feeding.applies());
  EXPECT_EQ(feeding.pressure_drop({}), 0.0);
}

// ---- Percentiles

TEST(WeightedPercentile, IsThatOfTheVolumeAndNotOfTheCells) {
  EXPECT_EQ(weighted_percentile({}, 0.95), 0.0);
  EXPECT_EQ(weighted_percentile({{3.0, 0.1}}, 0.95), 3.0);
  // A cell and its four quarters are the same metal.
  const double coarse = weighted_percentile({{1.0, 4.0}, {2.0, 4.0}, {9.0, 4.0}}, 0.5);
  const double fine = weighted_percentile(
      {{1.0, 4.0}, {2.0, 1.0}, {2.0, 1.0}, {2.0, 1.0}, {2.0, 1.0}, {9.0, 4.0}}, 0.5);
  EXPECT_EQ(coarse, 2.0);
  EXPECT_EQ(fine, 2.0);
}

// ---- Both indices of a section that freezes from the bottom upwards

mesh::SectionSpec section(int columns, int rows) {
  mesh::SectionSpec spec;
  spec.kind = mesh::SectionKind::plane_strain;
  spec.element = mesh::ElementKind::q1;
  spec.half_width = 0.28;
  spec.initial_depth = 0.2;
  spec.columns = columns;
  spec.rows = rows;
  spec.side_cell = 0.28 / columns;
  spec.bottom_cell = 0.2 / rows;
  return spec;
}

/// A front climbs through the section while the creep rate grows linearly across it.
class Freezing {
public:
  Freezing(int columns, int rows)
      : slab_(section(columns, rows)), tears_(card_, section(columns, rows)) {
    state_.started = true;
    state_.solid.assign(std::size_t(mesh().elements()), 1);
    state_.deviator.resize(std::size_t(mesh().elements()));
  }

  const mesh::Mesh2D& mesh() const { return slab_.mesh(); }

  TearIndices indices(double largest_rate) {
    std::vector<MushPassage> passages;
    constexpr double seconds = 0.25;
    for (double front = 0.0; front <= 0.25; front += velocity * seconds) {
      set_temperature(front);
      set_rates(largest_rate);
      tears_.follow({mesh(), temperature_, creep_rates(), seconds, 0.2, mesh().elements()},
                    passages);
    }
    return tears_.indices(mesh(), passages);
  }
  TearMap map_of_melt() {
    std::vector<MushPassage> passages;
    set_temperature(-0.1);
    tears_.follow({mesh(), temperature_, creep_rates(), 1.0, 0.2, mesh().elements()}, passages);
    return tears_.map(passages);
  }

private:
  std::vector<double> creep_rates() const {
    return tears_.creep_rates(state_, mesh::PlanTransfer().element_means<2>(mesh(), temperature_));
  }
  void set_temperature(double front) {
    temperature_.clear();
    for (int n = 0; n < mesh().nodes(); ++n)
      temperature_.push_back(liquidus + gradient * (mesh().point(n)[1] - front));
  }

  /// The deviator in which each element creeps at its rate.
  void set_rates(double largest) {
    const material::MechanicalProperties properties(card_);
    for (int e = 0; e < mesh().elements(); ++e) {
      double x = 0.0, t = 0.0;
      for (int i = 0; i < 4; ++i) {
        const int n = mesh().nodes_of(e)[i];
        x += 0.25 * mesh().point(n)[0];
        t += 0.25 * temperature_[std::size_t(n)];
      }
      const double wanted = std::sqrt(1.5) * largest * x / 0.28;
      const double kappa = properties.creep_factors(t).deviatoric;
      const double power = 1.0 / (properties.creep().exponent - 1.0);
      const double norm = kappa > 0.0 ? std::pow(wanted / kappa, power) : 0.0;
      state_.deviator[std::size_t(e)] = {{norm / std::sqrt(2.0), -norm / std::sqrt(2.0), 0.0, 0.0}};
    }
  }

  material::AlloyCard card_ = windowed_card();
  mesh::SlabMesh2D slab_;
  HotTears<2> tears_;
  mechanics::SlabState<2> state_;
  std::vector<double> temperature_;
};

/// 95 % of the metal is stretched at less than 0.95 of the largest rate.
TEST(HotTears, TheIndicesDoNotDependOnTheMesh) {
  const TearIndices coarse = Freezing(14, 10).indices(1e-3), fine = Freezing(56, 40).indices(1e-3);
  EXPECT_NEAR(coarse.strain_rate.overall, 0.95e-3, 0.02e-3);
  EXPECT_NEAR(fine.strain_rate.overall, 0.95e-3, 0.01e-3);
  EXPECT_NEAR(coarse.pressure.overall, fine.pressure.overall, 0.03 * fine.pressure.overall);
}

/// The rate grows from the middle to the side: the centre lies within the inner quarter.
TEST(HotTears, ThePlacesAreThoseWhereButtsTear) {
  const TearIndices found = Freezing(56, 40).indices(1e-3);
  EXPECT_NEAR(found.strain_rate.centre, 0.95 * 0.25e-3, 0.02e-3);
  EXPECT_NEAR(found.strain_rate.surface, 0.995e-3, 0.02e-3);
  EXPECT_GT(found.pressure.surface, found.pressure.centre);
}

TEST(HotTears, AFasterStretchRaisesBothIndices) {
  Freezing casting(14, 10);
  const TearIndices slow = casting.indices(1e-3), fast = casting.indices(2e-3);
  EXPECT_NEAR(fast.strain_rate.overall, 2.0 * slow.strain_rate.overall, 1e-9);
  EXPECT_GT(fast.pressure.overall, slow.pressure.overall);
}

TEST(HotTears, MeltHasNeither) {
  for (const double value : Freezing(14, 10).map_of_melt().strain_rate) EXPECT_EQ(value, 0.0);
  for (const double value : Freezing(14, 10).map_of_melt().pressure) EXPECT_EQ(value, 0.0);
}

TEST(HotTears, MergedCellsTakeTheMean) {
  const mesh::MergedRows merged{
      .height = {0.0, 0.1, 0.2, 0.3}, .taken_out = {1}, .nodes_per_row = 2, .elements_per_row = 1};
  std::vector<MushPassage> passages{{.temperature = 500.0, .strain = 1.0, .time = 2.0},
                                    {.temperature = 510.0, .strain = 3.0, .time = 4.0},
                                    {.temperature = 650.0}};
  merge_passages(merged, passages);
  ASSERT_EQ(passages.size(), 2u);
  EXPECT_EQ(passages[0].temperature, 505.0);
  EXPECT_EQ(passages[0].strain, 2.0);
  EXPECT_EQ(passages[0].time, 3.0);
  EXPECT_EQ(passages[1].temperature, 650.0);
}

// ---- Pores

/// A cold slab has the pores of its card in all its volume; melt has none.
TEST(Pores, AreTheShareOfTheVolumeThatIsCold) {
  const material::AlloyCard card = windowed_card();
  const mesh::SlabMesh2D slab(section(14, 10));
  const std::vector<double> cold(std::size_t(slab.mesh().nodes()), 20.0);
  const std::vector<double> hot(std::size_t(slab.mesh().nodes()), 700.0);
  const double share = material::MechanicalProperties(card).pore_share(20.0);
  ASSERT_GT(share, 0.0);

  const Pores pores(card, mesh::SectionKind::plane_strain);
  EXPECT_NEAR(pores.volume(slab.mesh(), cold), share * 0.28 * 0.2, 1e-3 * share * 0.28 * 0.2);
  EXPECT_EQ(pores.volume(slab.mesh(), hot), 0.0);

  const Pores round(card, mesh::SectionKind::axisymmetric);
  const double per_radian = share * 0.5 * 0.28 * 0.28 * 0.2;
  EXPECT_NEAR(round.volume(slab.mesh(), cold), per_radian, 1e-3 * per_radian);
}

TEST(Pores, ThereAreNoneInThePapersMush) {
  const mesh::SlabMesh2D slab(section(14, 10));
  const std::vector<double> cold(std::size_t(slab.mesh().nodes()), 20.0);
  const Pores pores(material::testing::paper_card(), mesh::SectionKind::plane_strain);
  EXPECT_EQ(pores.volume(slab.mesh(), cold), 0.0);
}

}  // namespace
}  // namespace dccast::casting
