#include "core/casting/findings/mush_feeding.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "core/material/thermal_properties.hpp"

namespace dccast::casting {

namespace {

constexpr double melt_viscosity = 1e-3;      // mu [Pa s], aluminium near its melting point
constexpr double freezing_shrinkage = 0.06;  // beta [1], Rappaz, Drezet and Gremaud
constexpr double carman_kozeny = 180.0;      // [1], of the same
constexpr int points_of_table = 8000;

/// A running integral by the trapezoidal rule, against falling temperature.
class Integral {
public:
  /// @param step  [K] since the last value
  double add(double value, double step) {
    sum_ += 0.5 * (value + last_) * step;
    last_ = value;
    return sum_;
  }

private:
  double sum_ = 0.0, last_ = 0.0;
};

/// A table against temperature from values that were computed from its upper end downwards.
Curve table_of(std::vector<double> falling, std::vector<double> values) {
  std::ranges::reverse(falling);
  std::ranges::reverse(values);
  return Curve(Abscissa::temperature, std::move(falling), std::move(values));
}

}  // namespace

MushFeeding::MushFeeding(const material::AlloyCard& card) {
  const material::HotTearWindow& window = card.hot_tears;
  if (window.arm_spacing <= 0.0 || window.end <= window.start) return;
  begin_ = card.liquidus;
  end_ = material::coherency_at(card, window.end);
  if (!applies()) return;

  scale_ = carman_kozeny * melt_viscosity / (window.arm_spacing * window.arm_spacing);

  std::vector<double> at, resistance, shrinkage, solid, stretch;
  Integral of_resistance, of_shrinkage, of_solid, of_stretch;
  const double spacing = (begin_ - end_) / points_of_table;
  for (int i = 0; i <= points_of_table; ++i) {
    const double step = i == 0 ? 0.0 : spacing;
    at.push_back(begin_ - i * spacing);

    // The table of a card may reach the end of the window a rounding error too early.
    const double fs = std::min(window.end, material::solid_fraction_at(card, at.back()));
    const double fl = 1.0 - fs;
    resistance.push_back(of_resistance.add(fs * fs / (fl * fl * fl), step));
    shrinkage.push_back(of_shrinkage.add(fs * fs / (fl * fl), step));
    solid.push_back(of_solid.add(fs, step));
    stretch.push_back(of_stretch.add(fs * resistance.back(), step));
  }

  resistance_ = table_of(at, std::move(resistance));
  shrinkage_ = table_of(at, std::move(shrinkage));
  solid_ = table_of(at, std::move(solid));
  stretch_ = table_of(at, std::move(stretch));
}

void MushFeeding::advance(Path& path, const Step& step) const {
  if (!applies()) return;
  if (step.to >= begin_) {
    path = {};
    return;
  }

  const double from = std::clamp(step.from, end_, begin_), to = std::clamp(step.to, end_, begin_);
  if (from == to) return;

  const double velocity = std::abs(step.from - step.to) / (step.gradient * step.time);  // [m/s]
  const auto gain = [&](const Curve& integral) { return integral(to) - integral(from); };

  // fs R = fs (R at the beginning of the step + resistance since then).
  const double since_then = gain(stretch_) - resistance_(from) * gain(solid_);
  path.stretched += step.strain_rate / step.gradient *
                    (path.resistance * gain(solid_) + since_then / step.gradient);
  path.shrunk += velocity / step.gradient * gain(shrinkage_);
  path.resistance += gain(resistance_) / step.gradient;

  // Warming metal must not go back further than it came.
  path.stretched = std::max(0.0, path.stretched);
  path.shrunk = std::max(0.0, path.shrunk);
  path.resistance = std::max(0.0, path.resistance);
}

double MushFeeding::pressure_drop(const Path& path) const {
  return scale_ * ((1.0 + freezing_shrinkage) * path.stretched + freezing_shrinkage * path.shrunk);
}

}  // namespace dccast::casting
