#include "tests/verification/heat/exact_solutions.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

namespace dccast::verification {
namespace {

/// Root of a function that is negative at `low` and positive at `high`, to the last digit.
double bisect(const std::function<double(double)>& function, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double middle = 0.5 * (low + high);
    if (middle == low || middle == high) break;
    (function(middle) < 0.0 ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// Derivative of erf.
double gauss(double x) {
  return 2.0 / std::sqrt(std::numbers::pi) * std::exp(-x * x);
}

}  // namespace

NeumannSolution::NeumannSolution(const StefanData& stefan)
    : stefan_(stefan),
      solid_diffusivity_(stefan.solid_conductivity / stefan.solid_capacity),
      liquid_diffusivity_(stefan.liquid_conductivity / stefan.liquid_capacity) {
  // Heat balance at the front: latent heat times its speed = flux into the solid less that out of
  // the liquid; multiplied by sqrt(t).
  const double solid_root = std::sqrt(solid_diffusivity_),
               liquid_root = std::sqrt(liquid_diffusivity_);
  const auto excess = [&](double lambda) {
    const double in_liquid = lambda * solid_root / liquid_root;
    const double from_solid = stefan_.solid_conductivity * (stefan_.change - stefan_.wall) *
                              gauss(lambda) / (2.0 * solid_root * std::erf(lambda));
    const double from_liquid = stefan_.liquid_conductivity * (stefan_.initial - stefan_.change) *
                               gauss(in_liquid) / (2.0 * liquid_root * std::erfc(in_liquid));
    return stefan_.latent_heat * lambda * solid_root - from_solid + from_liquid;
  };
  lambda_ = bisect(excess, 1e-9, 5.0);
}

double NeumannSolution::front(double time) const {
  return 2.0 * lambda_ * std::sqrt(solid_diffusivity_ * time);
}

double NeumannSolution::temperature(double depth, double time) const {
  if (depth < front(time)) {
    const double share =
        std::erf(0.5 * depth / std::sqrt(solid_diffusivity_ * time)) / std::erf(lambda_);
    return stefan_.wall + (stefan_.change - stefan_.wall) * share;
  }
  const double at_front = lambda_ * std::sqrt(solid_diffusivity_ / liquid_diffusivity_);
  const double share =
      std::erfc(0.5 * depth / std::sqrt(liquid_diffusivity_ * time)) / std::erfc(at_front);
  return stefan_.initial + (stefan_.change - stefan_.initial) * share;
}

MushySolution::MushySolution(const MushyStefanData& mushy)
    : mushy_(mushy),
      solid_root_(std::sqrt(mushy.solid_conductivity / mushy.solid_capacity)),
      mushy_root_(std::sqrt(mushy.mushy_conductivity / mushy.mushy_capacity())),
      liquid_root_(std::sqrt(mushy.liquid_conductivity / mushy.liquid_capacity)) {
  solidus_similarity_ =
      bisect([this](double s) { return flux_defect(s); }, 1e-9 * solid_root_, 3.0 * solid_root_);
  liquidus_similarity_ = liquidus_similarity(solidus_similarity_);
}

/// The mush is T_s + A (erf(s/root_m) - erf(s_1/root_m)); A follows from the flux at the solidus.
double MushySolution::mushy_amplitude(double s) const {
  const double solid_gradient = (mushy_.solidus - mushy_.wall) * gauss(s / solid_root_) /
                                (solid_root_ * std::erf(s / solid_root_));
  return mushy_.solid_conductivity / mushy_.mushy_conductivity * solid_gradient * mushy_root_ /
         gauss(s / mushy_root_);
}

/// Where that mush reaches the liquidus; infinite if it never does.
double MushySolution::liquidus_similarity(double s) const {
  const double wanted =
      std::erf(s / mushy_root_) + (mushy_.liquidus - mushy_.solidus) / mushy_amplitude(s);
  if (wanted >= 1.0) return INFINITY;
  return mushy_root_ * bisect([&](double x) { return std::erf(x) - wanted; }, 0.0, 7.0);
}

/// Flux into the liquidus front from the liquid less that which leaves it into the mush: negative
/// while the solidus is too shallow (the mush then conducts too well).
double MushySolution::flux_defect(double s) const {
  const double front = liquidus_similarity(s);
  if (std::isinf(front)) return 1.0;
  const double from_mush =
      mushy_.mushy_conductivity * mushy_amplitude(s) * gauss(front / mushy_root_) / mushy_root_;
  const double from_liquid = mushy_.liquid_conductivity * (mushy_.initial - mushy_.liquidus) *
                             gauss(front / liquid_root_) /
                             (liquid_root_ * std::erfc(front / liquid_root_));
  return from_liquid - from_mush;
}

double MushySolution::solidus_front(double time) const {
  return 2.0 * solidus_similarity_ * std::sqrt(time);
}

double MushySolution::liquidus_front(double time) const {
  return 2.0 * liquidus_similarity_ * std::sqrt(time);
}

double MushySolution::temperature(double depth, double time) const {
  const double s = 0.5 * depth / std::sqrt(time);
  if (s < solidus_similarity_) {
    return mushy_.wall + (mushy_.solidus - mushy_.wall) * std::erf(s / solid_root_) /
                             std::erf(solidus_similarity_ / solid_root_);
  }
  if (s < liquidus_similarity_) {
    return mushy_.solidus +
           mushy_amplitude(solidus_similarity_) *
               (std::erf(s / mushy_root_) - std::erf(solidus_similarity_ / mushy_root_));
  }
  return mushy_.initial + (mushy_.liquidus - mushy_.initial) * std::erfc(s / liquid_root_) /
                              std::erfc(liquidus_similarity_ / liquid_root_);
}

double strand_enthalpy(const StrandData& strand, double temperature) {
  const auto& at = strand.temperature;
  std::size_t right =
      static_cast<std::size_t>(std::upper_bound(at.begin(), at.end(), temperature) - at.begin());
  right = std::clamp<std::size_t>(right, 1, at.size() - 1);
  const double slope =
      (strand.enthalpy[right] - strand.enthalpy[right - 1]) / (at[right] - at[right - 1]);
  return strand.enthalpy[right - 1] + slope * (temperature - at[right - 1]);
}

StrandSolution::StrandSolution(const StrandData& strand) : strand_(strand) {
  // T falls downwards, so the heat flow exceeds what the hottest metal carries along. The more it
  // exceeds it, the shorter the way to the bottom's temperature. In a long strand the excess is
  // exponentially small: hence the logarithm, and hence the excess and not the flow as the unknown.
  const double drop = strand.top_temperature - strand.bottom_temperature;
  const double scale = strand.speed * (strand_enthalpy(strand, strand.top_temperature) -
                                       strand_enthalpy(strand, strand.bottom_temperature)) +
                       strand.conductivity * drop / strand.length;
  const auto too_short = [&](double logarithm) {
    return strand.length - depth_for(strand.bottom_temperature, scale * std::exp(logarithm));
  };
  excess_ = scale * std::exp(bisect(too_short, -600.0, 5.0));
}

/// Sum over the pieces of H(T) between the top and T of k/(V c) ln of the ratio of -k T' at its
/// ends.
/// @param excess  -k T' at the top [W/m2]
double StrandSolution::depth_for(double temperature, double excess) const {
  std::vector<double> stops{strand_.top_temperature};
  for (auto point = strand_.temperature.rbegin(); point != strand_.temperature.rend(); ++point) {
    if (*point<strand_.top_temperature&& * point> temperature) stops.push_back(*point);
  }
  stops.push_back(temperature);
  const double top = strand_enthalpy(strand_, strand_.top_temperature);
  double depth = 0.0;
  for (std::size_t i = 1; i < stops.size(); ++i) {
    if (stops[i - 1] == stops[i]) continue;
    const double hot = strand_enthalpy(strand_, stops[i - 1]);
    const double cold = strand_enthalpy(strand_, stops[i]);
    const double capacity = (hot - cold) / (stops[i - 1] - stops[i]);
    depth +=
        strand_.conductivity / (strand_.speed * capacity) *
        std::log((excess + strand_.speed * (top - cold)) / (excess + strand_.speed * (top - hot)));
  }
  return depth;
}

double StrandSolution::depth(double temperature) const {
  return depth_for(temperature, excess_);
}

double StrandSolution::temperature(double depth) const {
  return bisect([&](double t) { return depth - depth_for(t, excess_); }, strand_.bottom_temperature,
                strand_.top_temperature);
}

double StrandSolution::heat_flow() const {
  return excess_ + strand_.speed * strand_enthalpy(strand_, strand_.top_temperature);
}

}  // namespace dccast::verification
