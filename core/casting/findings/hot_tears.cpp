#include "core/casting/findings/hot_tears.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "core/casting/findings/element_centre.hpp"
#include "core/material/norton_hoff.hpp"
#include "core/material/thermal_properties.hpp"
#include "core/mechanics/constitutive.hpp"

namespace dccast::casting {

namespace {

/// Share of the way between two temperatures that lies in a range [1].
double share_within(double from, double to, double low, double high) {
  const double lower = std::min(from, to), upper = std::max(from, to);
  if (upper - lower <= 0.0) return lower >= low && lower <= high ? 1.0 : 0.0;
  return std::max(0.0, std::min(upper, high) - std::max(lower, low)) / (upper - lower);
}

// The two places where butts of all sizes tear: near the middle, and where the shell leaves the
// block's lip. Widths of the centre are shares of each half dimension, other lengths of the smaller
// one.
constexpr double centre_width = 0.25, centre_height = 0.5;    // [1]
constexpr double surface_depth = 0.1, surface_height = 0.25;  // [1]

/// The two places of a section where butts tear.
template <int Dim>
class Places {
public:
  Places(const mesh::SectionSpec& section, const mesh::Mesh<Dim>& mesh) : section_(section) {
    for (int d = 0; d < Dim - 1; ++d) half_[std::size_t(d)] = mesh.largest(d);
    scale_ = *std::ranges::min_element(half_);
  }

  bool at_centre(const std::array<double, Dim>& place) const {
    for (std::size_t d = 0; d < half_.size(); ++d)
      if (place[d] > centre_width * half_[d]) return false;
    return place[Dim - 1] <= centre_height * scale_;
  }
  bool at_surface(const std::array<double, Dim>& place) const {
    return place[Dim - 1] <= surface_height * scale_ &&
           distance_from_faces(place) <= surface_depth * scale_;
  }

private:
  double distance_from_faces(const std::array<double, Dim>& place) const {
    const double narrow = half_[0] - place[0];
    if (Dim == 2 || section_.half_thickness.empty()) return narrow;
    return std::min(narrow, section_.half_thickness(place[0]) - place[1]);
  }

  const mesh::SectionSpec& section_;
  std::array<double, Dim - 1> half_{};  // [m] half dimensions
  double scale_ = 0.0;                  // [m] the smaller one
};

/// Values of all metal and of the two places.
struct Samples {
  std::vector<WeightedValue> overall, centre, surface;

  void add(WeightedValue value, bool at_centre, bool at_surface) {
    overall.push_back(value);
    if (at_centre) centre.push_back(value);
    if (at_surface) surface.push_back(value);
  }
  TearIndex index() && {
    return {weighted_percentile(std::move(overall), tear_percentile),
            weighted_percentile(std::move(centre), tear_percentile),
            weighted_percentile(std::move(surface), tear_percentile)};
  }
};

}  // namespace

double weighted_percentile(std::vector<WeightedValue> values, double share) {
  if (values.empty()) return 0.0;
  std::ranges::sort(values, {}, &WeightedValue::value);
  double whole = 0.0;
  for (const WeightedValue& v : values) whole += v.weight;

  // Each value stands at the middle of its weight; between middles it is linear.
  const double wanted = share * whole;
  double below = 0.0, middle_before = 0.0, value_before = values.front().value;
  for (const WeightedValue& v : values) {
    const double middle = below + 0.5 * v.weight;
    if (middle >= wanted) {
      const double width = middle - middle_before;
      const double part = width > 0.0 ? (wanted - middle_before) / width : 1.0;
      return value_before + part * (v.value - value_before);
    }
    below += v.weight;
    middle_before = middle;
    value_before = v.value;
  }
  return values.back().value;
}

template <int Dim>
HotTears<Dim>::HotTears(const material::AlloyCard& card, const mesh::SectionSpec& section)
    : properties_(card),
      feeding_(card),
      has_window_(card.hot_tears.end > card.hot_tears.start),
      liquidus_(card.liquidus),
      section_(section) {
  if (!has_window_) return;
  window_begin_ = material::coherency_at(card, card.hot_tears.start);
  window_end_ = material::coherency_at(card, card.hot_tears.end);
}

template <int Dim>
std::vector<double> HotTears<Dim>::creep_rates(const mechanics::SlabState<Dim>& slab,
                                               std::span<const double> temperature) const {
  if (!has_window_ || !slab.started) return {};
  const double exponent = properties_.creep().exponent;
  const std::size_t points = slab.deviator.size() / slab.solid.size();

  std::vector<double> rates(slab.solid.size(), 0.0);
  for (std::size_t e = 0; e < rates.size(); ++e) {
    if (slab.solid[e] == 0) continue;
    const double kappa = properties_.creep_factors(temperature[e]).deviatoric;

    // Norton-Hoff law: kappa |s|^(q-2) |s|, as an equivalent rate.
    double sum = 0.0;
    for (std::size_t q = 0; q < points; ++q) {
      const double norm = slab.deviator[e * points + q].norm();
      sum += mechanics::equivalent_of_norm * kappa * material::creep_power(norm, exponent) * norm;
    }
    rates[e] = sum / static_cast<double>(points);
  }
  return rates;
}

template <int Dim>
void HotTears<Dim>::pass(const Step& step, int e, MushPassage& passage) const {
  const double to = mesh::mean_at_nodes(step.mesh, e, step.temperature);
  const double last = std::min(window_end_, feeding_.applies() ? feeding_.end() : window_end_);
  const double from = std::min(passage.temperature, std::max(liquidus_, to));
  passage.temperature = to;
  if (from <= last && to <= last) return;

  // Metal that has melted again begins anew.
  if (to > window_begin_) passage.strain = passage.time = 0.0;
  if (to >= liquidus_) {
    passage.feeding = {};
    return;
  }

  const bool started = !step.creep_rate.empty();
  const double rate = started ? step.creep_rate[std::size_t(e)] : 0.0;
  if (started) {
    const double seconds = step.time * share_within(from, to, window_end_, window_begin_);
    passage.time += seconds;
    passage.strain += seconds * rate;
  }
  if (!feeding_.applies()) return;

  // No mush is longer than the metal is deep, however flat the temperature.
  const double flattest = (feeding_.begin() - feeding_.end()) / step.metal_level;
  const double gradient = centre_of(step.mesh, e, step.temperature, false).gradient;
  feeding_.advance(passage.feeding, {.from = from,
                                     .to = to,
                                     .time = step.time,
                                     .gradient = std::max(flattest, gradient),
                                     .strain_rate = rate});
}

template <int Dim>
void HotTears<Dim>::follow(const Step& step, std::vector<MushPassage>& passages) const {
  if (!has_window_) return;
  passages.resize(std::size_t(step.mesh.elements()));
  for (int e = 0; e < step.growing; ++e) pass(step, e, passages[std::size_t(e)]);
}

template <int Dim>
TearIndices HotTears<Dim>::indices(const mesh::Mesh<Dim>& mesh,
                                   const std::vector<MushPassage>& passages) const {
  if (!has_window_) return {};
  const bool round = section_.kind == mesh::SectionKind::axisymmetric;
  const Places<Dim> places(section_, mesh);
  const std::vector<double> none(std::size_t(mesh.nodes()), 0.0);

  Samples rates, drops;
  for (std::size_t e = 0; e < passages.size(); ++e) {
    const MushPassage& passage = passages[e];
    // Metal that is still in the window has no index yet.
    if (passage.temperature > window_end_) continue;

    const auto centre = centre_of(mesh, static_cast<int>(e), none, round);
    const bool inside = places.at_centre(centre.place), outside = places.at_surface(centre.place);
    if (passage.time > 0.0) rates.add({passage.strain_rate(), centre.volume}, inside, outside);
    if (passage.feeding.resistance > 0.0)
      drops.add({feeding_.pressure_drop(passage.feeding), centre.volume}, inside, outside);
  }
  return {std::move(rates).index(), std::move(drops).index()};
}

template <int Dim>
TearMap HotTears<Dim>::map(const std::vector<MushPassage>& passages) const {
  TearMap map;
  for (const MushPassage& passage : passages) {
    map.strain_rate.push_back(passage.strain_rate());
    map.pressure.push_back(feeding_.pressure_drop(passage.feeding));
  }
  return map;
}

void merge_passages(const mesh::MergedRows& merged, std::vector<MushPassage>& passages) {
  if (passages.empty()) return;
  const auto mean = [](const MushPassage& a, const MushPassage& b) {
    const auto average = [](double x, double y) { return 0.5 * (x + y); };
    return MushPassage{
        .temperature = average(a.temperature, b.temperature),
        .strain = average(a.strain, b.strain),
        .time = average(a.time, b.time),
        .feeding = {.resistance = average(a.feeding.resistance, b.feeding.resistance),
                    .stretched = average(a.feeding.stretched, b.feeding.stretched),
                    .shrunk = average(a.feeding.shrunk, b.feeding.shrunk)}};
  };

  // A merged cell takes the mean of the two cells that it replaces.
  const std::size_t cells = merged.elements_per_row;
  std::vector<MushPassage> after;
  for (const auto& [first, last] : merged.made_of())
    for (std::size_t i = 0; i < cells; ++i)
      after.push_back(mean(passages[first * cells + i], passages[last * cells + i]));
  passages = std::move(after);
}

template class HotTears<2>;
template class HotTears<3>;

}  // namespace dccast::casting
