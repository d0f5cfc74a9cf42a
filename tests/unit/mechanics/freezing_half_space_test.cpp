#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/unit/mechanics/bodies.hpp"

/// Weiner and Boley's half space: melt at its melting point freezes from a wall whose temperature
/// is held. The metal is elastic and perfectly plastic, its yield stress falls linearly to zero at
/// the melting point, and it stays flat with no force across (J. Mech. Phys. Solids 11, 1963).
namespace dccast::mechanics {
namespace {

using namespace testing;

constexpr double melting = 1495.0, wall = 1000.0;  // [degC]
constexpr double young = 40e9, poisson = 0.3, expansion = 2e-5, wall_yield = 20e6;
constexpr double conductivity = 33.0, capacity = 661.0, latent = 272e3, density = 7500.0;
constexpr double diffusivity = conductivity / (density * capacity);  // [m2/s]
constexpr double biaxial = young / (1.0 - poisson);                  // [Pa]

template <class Function>
double root_between(double low, double high, Function&& rising) {
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (rising(middle) > 0.0 ? high : low) = middle;
  }
  return 0.5 * (low + high);
}

/// Temperature: Neumann's solution. Depth of the front: 2 gamma sqrt(diffusivity t).
struct FrozenLayer {
  double gamma = root_between(1e-3, 3.0, [](double g) {
    return std::sqrt(std::numbers::pi) * g * std::exp(g * g) * std::erf(g) -
           capacity * (melting - wall) / latent;
  });

  double front(double time) const { return 2.0 * gamma * std::sqrt(diffusivity * time); }
  /// @param xi  depth relative to the front [1] @return [degC]
  double temperature(double xi) const {
    return xi >= 1.0 ? melting : wall + (melting - wall) * std::erf(gamma * xi) / std::erf(gamma);
  }
  double slope(double xi) const {
    return (melting - wall) * 2.0 * gamma / std::sqrt(std::numbers::pi) *
           std::exp(-gamma * gamma * xi * xi) / std::erf(gamma);
  }
};

double yield_at(double temperature) {
  return wall_yield * (melting - temperature) / (melting - wall);
}

/// The stress depends on the relative depth alone. From the front inwards: tensile yielding, then
/// elastic unloading, which begins without a kink, then yielding in compression at the wall. In the
/// elastic part the strain across grows as c / t, so that
///     stress = offset - E / (1 - nu) (2 c ln(xi) + alpha T).
class ExactStress {
public:
  explicit ExactStress(const FrozenLayer& layer) : layer_(layer) {
    tensile_from_ = root_between(0.2, 0.999, [&](double xi) {
      fit(xi);
      return force();
    });
    fit(tensile_from_);
  }

  double operator()(double xi) const {
    const double yield = yield_at(layer_.temperature(xi));
    return xi >= tensile_from_ ? yield : std::max(-yield, elastic(xi));
  }
  double tensile_from() const { return tensile_from_; }
  /// c: the strain across grows by c ln(t2 / t1) from t1 to t2 [1].
  double growth() const { return growth_; }

private:
  double elastic(double xi) const {
    return offset_ - biaxial * (2.0 * growth_ * std::log(xi) + expansion * layer_.temperature(xi));
  }
  void fit(double xi) {
    tensile_from_ = xi;
    const double yield_slope = -wall_yield / (melting - wall) * layer_.slope(xi);
    growth_ = -0.5 * xi * (yield_slope / biaxial + expansion * layer_.slope(xi));
    offset_ = 0.0;
    offset_ = yield_at(layer_.temperature(xi)) - elastic(xi);
  }
  double force() const {
    constexpr int points = 20000;
    double sum = 0.0;
    for (int i = 0; i < points; ++i) sum -= (*this)((i + 0.5) / points);
    return sum / points;
  }

  FrozenLayer layer_;
  double tensile_from_ = 1.0, growth_ = 0.0, offset_ = 0.0;
};

/// A disc, one cell wide, whose rim moves so that all layers stretch alike and no force is left
/// across it. The wall is its bottom.
template <class Element>
class Disc {
public:
  static constexpr double radius = 0.02, height = 0.03;
  static constexpr int cells = 120;

  Disc() : body_(box<Element>({radius, height}, {1, cells})) {
    body_.set_material(young, poisson, 0.0, 6.0);
    const std::size_t elements = std::size_t(body_.mesh.elements());
    body_.problem.yield.assign(elements, 0.0);
    body_.problem.hardening.assign(elements, 0.0);
    body_.problem.hardened.assign(elements * Element::points, 0.0);
    hold_low_end(body_, 1);
    unknowns_ = body_.unknowns();
  }

  void step(const FrozenLayer& layer, double time, double dt) {
    cool(layer, time);
    body_.problem.dt = dt;

    // The force rises with the stretch, but hardly while all layers yield: false position between
    // two stretches of which one pulls and one pushes, halving the value that stays (Illinois).
    double low = stretch_, high = stretch_;
    double pushing = stretched(low), pulling = pushing;
    for (double reach = 1e-6; pushing >= 0.0; reach *= 2.0) {
      high = std::exchange(low, low - reach);
      pulling = std::exchange(pushing, stretched(low));
    }
    for (double reach = 1e-6; pulling <= 0.0; reach *= 2.0) {
      low = std::exchange(high, high + reach);
      pushing = std::exchange(pulling, stretched(high));
    }
    double now = high;
    for (int i = 0, side = 0; i < 60 && high - low > 1e-13; ++i) {
      now = (low * pulling - high * pushing) / (pulling - pushing);
      const double force = stretched(now);
      if (std::abs(force) < 1e-9 * wall_yield * height) break;
      if (force > 0.0) {
        high = now;
        pulling = force;
        if (side == 1) pushing *= 0.5;
        side = 1;
      } else {
        low = now;
        pushing = force;
        if (side == -1) pulling *= 0.5;
        side = -1;
      }
    }

    stretch_ = now;
    unknowns_ = trial_;
    accumulate_viscoplastic_strain(body_.problem, unknowns_.deviator, unknowns_.displacement,
                                   body_.problem.hardened, body_.problem.inelastic);
    forget_strain_of_melt();
  }

  double depth(int element) const { return height_of(body_.mesh, element); }
  double stretch() const { return stretch_; }
  int elements() const { return body_.mesh.elements(); }
  /// Mean of the radial stress over the points of an element [Pa].
  double across(int element) const {
    double sum = 0.0;
    for (std::size_t q = 0; q < Element::points; ++q)
      sum += unknowns_.deviator[std::size_t(element) * Element::points + q][0];
    return sum / double(Element::points) +
           mean_normal_stress(body_.problem, element, unknowns_.displacement);
  }

private:
  bool is_molten(int element) const { return body_.problem.thermal[std::size_t(element)] >= 0.0; }

  void cool(const FrozenLayer& layer, double time) {
    constexpr double no_creep = 1e-70;  // [Pa^-5/s]
    constexpr double of_melt = 1e-6;    // [1] what melt keeps of the shear modulus
    constexpr double shear = young / (2.0 * (1.0 + poisson));
    for (int e = 0; e < elements(); ++e) {
      const std::size_t i = std::size_t(e);
      const double temperature = layer.temperature(depth(e) / layer.front(time));
      body_.problem.thermal[i] = expansion * (temperature - melting);
      body_.problem.yield[i] = std::sqrt(2.0 / 3.0) * yield_at(temperature);
      body_.problem.kappa[i] = no_creep;
      body_.problem.shear[i] = shear;
      if (!is_molten(e)) continue;
      body_.problem.yield[i] = wall_yield;
      body_.problem.kappa[i] = 0.0;
      body_.problem.shear[i] = of_melt * shear;
    }
  }

  /// Melt forgets its strain: it freezes without stress.
  void forget_strain_of_melt() {
    for (int e = 0; e < elements(); ++e) {
      if (!is_molten(e)) continue;
      for (std::size_t q = 0; q < Element::points; ++q) {
        body_.problem.inelastic[std::size_t(e) * Element::points + q] =
            body_.forms.strain(std::size_t(e), q, unknowns_.displacement);
      }
    }
  }

  /// Solves the step with a given stretch. @return force across [N/m]
  double stretched(double stretch) {
    for (int n = 0; n < body_.mesh.nodes(); ++n) body_.fix(n, 0, stretch * body_.mesh.point(n)[0]);
    trial_ = unknowns_;
    EXPECT_TRUE(solve_step(body_.problem, tight(1e-8), body_.work, trial_).converged) << stretch;

    std::swap(unknowns_, trial_);
    double force = 0.0;
    for (int e = 0; e < elements(); ++e) force += across(e) * height / elements();
    std::swap(unknowns_, trial_);
    return force;
  }

  FixedBody<Element> body_;
  StepUnknowns<2> unknowns_, trial_;
  double stretch_ = 0.0;
};

TEST(FreezingHalfSpace, ExactStressIsInEquilibriumAndYieldsAtBothEnds) {
  const FrozenLayer layer;
  const ExactStress exact(layer);
  EXPECT_NEAR(exact(1e-9), -wall_yield, 1.0) << "the wall yields in compression";
  EXPECT_NEAR(exact(exact.tensile_from()), yield_at(layer.temperature(exact.tensile_from())), 1.0);

  double force = 0.0;
  for (int i = 0; i < 1000; ++i) force += 1e-3 * exact((i + 0.5) / 1000.0);
  EXPECT_NEAR(force, 0.0, 1e-4 * wall_yield);
}

/// Largest error of the stress, relative to the largest stress.
TEST(FreezingHalfSpace, StressesAreWithinTwoPercent) {
  const FrozenLayer layer;
  const ExactStress exact(layer);
  Disc<fem::AxisymmetricQ1> disc;

  const double end = std::pow(0.8 * disc.height / (2.0 * layer.gamma), 2.0) / diffusivity;
  constexpr int steps = 600;
  // Equal advances of the front.
  double time = 0.0;
  for (int i = 10; i <= steps; ++i) {  // with two layers frozen at first
    const double next = end * std::pow(double(i) / steps, 2.0);
    disc.step(layer, next, next - time);
    time = next;
  }

  double largest = 0.0;
  for (int e = 0; e < disc.elements(); ++e) {
    const double xi = disc.depth(e) / layer.front(end);
    if (xi >= 1.0) continue;
    largest = std::max(largest, std::abs(disc.across(e) - exact(xi)));
  }
  EXPECT_LE(largest, 0.02 * wall_yield);
}

}  // namespace
}  // namespace dccast::mechanics
