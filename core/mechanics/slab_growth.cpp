#include "core/mechanics/slab_growth.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/fem/element.hpp"
#include "core/mechanics/slab_mechanics.hpp"

namespace dccast::mechanics {

namespace {

/// Integration points of an element on one vertical line, the lower one first.
template <int Dim>
std::array<std::array<std::size_t, 2>, RowsOfPoints<Dim>::points / 2> upright_lines() {
  constexpr std::size_t up = Dim - 1;
  constexpr auto& point = fem::Q1<Dim>::point;
  std::array<std::array<std::size_t, 2>, RowsOfPoints<Dim>::points / 2> lines{};
  std::size_t found = 0;
  for (std::size_t low = 0; low < point.size(); ++low) {
    if (point[low][up] > 0.0) continue;
    auto above = point[low];
    above[up] = -above[up];
    for (std::size_t high = 0; high < point.size(); ++high) {
      if (point[high] == above) lines[found++] = {low, high};
    }
  }
  return lines;
}

/// Weights by which the values at the lower and upper points of two cells, one above the other,
/// give those of the merged cell: the linear function with the same mean and first moment [1].
/// @param height  [m] of the cells @return  (point after, point before, from below)
std::array<std::array<double, 4>, 2> weights(const std::array<double, 2>& height) {
  const double g = 1.0 / std::sqrt(3.0);
  const double low = height[0], high = height[1], whole = low + high;
  // Integral, and first moment about the middle of the whole, of each value.
  const double lever = low * high / 4.0, of_low = low * low / (12.0 * g),
               of_high = high * high / (12.0 * g);
  const std::array<double, 4> integral{low / 2.0, low / 2.0, high / 2.0, high / 2.0};
  const std::array<double, 4> moment{-lever - of_low, -lever + of_low, lever - of_high,
                                     lever + of_high};
  std::array<std::array<double, 4>, 2> weight{};
  for (std::size_t i = 0; i < 4; ++i) {
    const double mean = integral[i] / whole, slope = 6.0 * g * moment[i] / (whole * whole);
    weight[0][i] = mean - slope;
    weight[1][i] = mean + slope;
  }
  return weight;
}

}  // namespace

template <int Dim>
std::array<double, 2> RowsOfPoints<Dim>::heights(std::size_t row) const {
  const auto [low, high] = rows_[row];
  const auto height = [&](std::size_t r) { return merged_.height[r + 1] - merged_.height[r]; };
  return {height(low), low == high ? 0.0 : height(high)};
}

template <int Dim>
template <class Use>
void RowsOfPoints<Dim>::for_each_element(const Use& use) const {
  const std::size_t per_row = merged_.elements_per_row;
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    for (std::size_t i = 0; i < per_row; ++i)
      use(row, row * per_row + i, rows_[row][0] * per_row + i, rows_[row][1] * per_row + i);
  }
}

template <int Dim>
bool RowsOfPoints<Dim>::is_pair(std::size_t element) const {
  const auto& row = rows_[element / merged_.elements_per_row];
  return row[0] != row[1];
}

template <int Dim>
std::vector<SymmetricTensor<Dim>> RowsOfPoints<Dim>::projected(
    std::span<const Tensor> field) const {
  static const auto lines = upright_lines<Dim>();
  std::vector<Tensor> after(rows_.size() * merged_.elements_per_row * points);

  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    if (low == high) {
      for (std::size_t q = 0; q < points; ++q) after[e * points + q] = field[low * points + q];
      return;
    }

    const auto weight = weights(heights(row));
    for (const auto& line : lines) {
      for (std::size_t end = 0; end < 2; ++end) {
        Tensor& value = after[e * points + line[end]];
        for (std::size_t i = 0; i < 4; ++i)
          value.add(weight[end][i], field[(i < 2 ? low : high) * points + line[i % 2]]);
      }
    }
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::means(std::span<const double> field) const {
  std::vector<double> after(rows_.size() * merged_.elements_per_row * points);
  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    const auto height = heights(row);
    const double mean = (height[0] * field[low * points] + height[1] * field[high * points]) /
                        (height[0] + height[1]);
    for (std::size_t q = 0; q < points; ++q) after[e * points + q] = mean;
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::point_means(std::span<const double> field) const {
  static const auto lines = upright_lines<Dim>();
  std::vector<double> after(rows_.size() * merged_.elements_per_row * points);
  for_each_element([&](std::size_t row, std::size_t e, std::size_t low, std::size_t high) {
    const auto height = heights(row);
    if (low == high) {
      for (std::size_t q = 0; q < points; ++q) after[e * points + q] = field[low * points + q];
      return;
    }

    for (const auto& line : lines) {
      const std::size_t lower = line[0], upper = line[1];
      const auto mean = [&](std::size_t element) {
        return 0.5 * (field[element * points + lower] + field[element * points + upper]);
      };
      const double of_line =
          (height[0] * mean(low) + height[1] * mean(high)) / (height[0] + height[1]);
      after[e * points + lower] = after[e * points + upper] = of_line;
    }
  });
  return after;
}

template <int Dim>
std::vector<char> RowsOfPoints<Dim>::all_of(std::span<const char> flag) const {
  std::vector<char> after(rows_.size() * merged_.elements_per_row);
  for_each_element([&](std::size_t, std::size_t e, std::size_t low, std::size_t high) {
    after[e] = flag[low] != 0 && flag[high] != 0 ? 1 : 0;
  });
  return after;
}

template <int Dim>
std::vector<double> RowsOfPoints<Dim>::restricted(std::vector<double> force) const {
  mesh::share_out_rows(merged_, merged_.nodes_per_row * Dim, force);
  return force;
}

template class RowsOfPoints<2>;
template class RowsOfPoints<3>;

// Transfer of the state of a slab to a changed mesh: growth and merged rows.

namespace {

/// Elastic strains including the thermal part, for the points from `first` on [1].
/// @param displacement  by unknown [m], which has set the rotations of the forms
template <int Dim>
std::vector<SymmetricTensor<Dim>> elastic_strains(const MechanicsForms<Dim>& forms,
                                                  const SlabState<Dim>& state,
                                                  std::span<const double> displacement,
                                                  std::size_t first = 0) {
  std::vector<SymmetricTensor<Dim>> elastic;
  for (std::size_t i = first; i < state.inelastic.size(); ++i) {
    elastic.push_back(forms.strain(i / forms.points(), i % forms.points(), displacement));
    elastic.back().add(-1.0, state.inelastic[i]);
  }
  return elastic;
}

/// Sets the inelastic strains from point `first` on such that the elastic strains are the given
/// ones; zero for points beyond these.
template <int Dim>
void set_elastic_strains(const MechanicsForms<Dim>& forms, SlabState<Dim>& state,
                         std::span<const double> displacement,
                         const std::vector<SymmetricTensor<Dim>>& elastic, std::size_t first = 0) {
  for (std::size_t i = first; i < state.inelastic.size(); ++i) {
    state.inelastic[i] = forms.strain(i / forms.points(), i % forms.points(), displacement);
    if (i - first < elastic.size()) state.inelastic[i].add(-1.0, elastic[i - first]);
  }
}

}  // namespace

template <int Dim>
void SlabMechanics<Dim>::follow_growth(State& state, const Mesh& grown, int nodes_per_row,
                                       int first_moved) {
  const std::size_t first = std::size_t(first_moved) * points_;
  const int old_nodes = static_cast<int>(state.released.size());
  std::vector<double> u = supports_.by_unknown(state.displacement);
  set_rotations(u, state.solid);
  const std::vector<Tensor> elastic = elastic_strains(*forms_, state, u, first);

  const std::size_t stride = std::size_t(nodes_per_row) * Dim;
  for (std::size_t i = state.displacement.size(); i < std::size_t(grown.nodes()) * Dim; ++i) {
    state.displacement.push_back(state.displacement[i - stride]);
  }

  state.released.resize(std::size_t(grown.nodes()), 0);
  state.solid.resize(std::size_t(grown.elements()), 0);
  const std::size_t all_points = std::size_t(grown.elements()) * points_;
  state.inelastic.resize(all_points);
  state.viscoplastic.resize(all_points);
  if (properties_.has_yield_limit()) state.hardened.resize(all_points, 0.0);
  state.deviator.resize(all_points);
  state.pressure.resize(all_points, 0.0);

  set_mesh(grown, first_moved);
  // A new node is at the mould, whatever the displacement of the one below it.
  u = supports_.by_unknown(std::move(state.displacement));
  supports_.stand_at_mould(u, old_nodes);
  set_rotations(u, state.solid);
  set_elastic_strains(*forms_, state, u, elastic, first);
  state.displacement = supports_.by_coordinate(std::move(u));
}

/// Forces of the stress in a state on the present mesh.
template <int Dim>
StressForces SlabMechanics<Dim>::forces_of_stress(const State& state) const {
  const std::size_t places = elements_in_block * points_;
  std::vector<double> force(problem_.unknowns(), 0.0), numbers(places * Tensor::components),
      pressure(places);
  const TensorBlock<Dim> deviator(numbers.data(), places);
  double squares = 0.0;
  for (std::size_t first = 0; first < forms_->elements(); first += elements_in_block) {
    const ElementBlock block{first, std::min(first + elements_in_block, forms_->elements())};
    for (std::size_t e = block.first; e < block.end; ++e) {
      for (std::size_t q = 0; q < points_; ++q) {
        deviator.set(place_in_block(e - first, q), state.deviator[e * points_ + q]);
        pressure[place_in_block(e - first, q)] = state.pressure[e * points_ + q];
      }
    }
    forms_->add_forces(block, deviator, pressure, force, squares);
  }
  return {supports_.by_coordinate(std::move(force)), std::sqrt(squares)};
}

template <int Dim>
ProjectedState<Dim> SlabMechanics<Dim>::projected(const State& state,
                                                  const mesh::MergedRows& merged,
                                                  std::span<const double> temperature) {
  if (points_ != RowsOfPoints<Dim>::points)
    throw std::logic_error("SlabMechanics: only rows of whole cells can be merged");

  const RowsOfPoints<Dim> rows(merged);
  const std::vector<double> u = supports_.by_unknown(state.displacement);
  set_rotations(u, state.solid);
  std::vector<Tensor> elastic = elastic_strains(*forms_, state, u);
  std::vector<double> dilatation;  // one of an element, as its pressure
  for (Tensor& strain : elastic) {
    dilatation.push_back(strain.trace());
    strain = strain.deviator();
  }

  set_weight(state, temperature);
  ProjectedState<Dim> to{state, rows.projected(elastic),
                         rows.restricted(forces_of_stress(state).nodal), problem_.weight};
  dilatation = rows.means(dilatation);
  for (std::size_t i = 0; i < dilatation.size(); ++i)
    to.elastic[i].add_identity(dilatation[i] / 3.0);

  to.state.viscoplastic = rows.projected(state.viscoplastic);
  to.state.deviator = rows.projected(state.deviator);
  to.state.pressure = rows.means(state.pressure);
  if (!state.hardened.empty()) to.state.hardened = rows.point_means(state.hardened);
  to.state.solid = rows.all_of(state.solid);
  for (std::size_t i = 0; i < to.elastic.size(); ++i)
    if (to.state.solid[i / points_] == 0 && rows.is_pair(i / points_)) to.elastic[i] = {};

  mesh::take_out_rows(merged, merged.nodes_per_row * Dim, to.state.displacement);
  mesh::take_out_rows(merged, merged.nodes_per_row, to.state.released);
  return to;
}

template <int Dim>
MergeChecks SlabMechanics<Dim>::follow_merging(State& state, ProjectedState<Dim> projected,
                                               const Mesh& merged_mesh,
                                               std::span<const double> temperature) {
  state = std::move(projected.state);
  set_mesh(merged_mesh);
  const std::vector<double> u = supports_.by_unknown(state.displacement);
  set_rotations(u, state.solid);
  state.inelastic.resize(projected.elastic.size());
  set_elastic_strains(*forms_, state, u, projected.elastic);
  set_weight(state, temperature);
  double squares = 0.0;
  const auto [force, acting] = forces_of_stress(state);
  for (std::size_t i = 0; i < force.size(); ++i)
    squares += (force[i] - projected.force[i]) * (force[i] - projected.force[i]);
  return {std::abs(problem_.weight - projected.weight) / projected.weight,
          acting > 0.0 ? std::sqrt(squares) / acting : 0.0};
}

template void SlabMechanics<2>::follow_growth(State&, const Mesh&, int, int);
template void SlabMechanics<3>::follow_growth(State&, const Mesh&, int, int);
template ProjectedState<2> SlabMechanics<2>::projected(const State&, const mesh::MergedRows&,
                                                       std::span<const double>);
template ProjectedState<3> SlabMechanics<3>::projected(const State&, const mesh::MergedRows&,
                                                       std::span<const double>);
template MergeChecks SlabMechanics<2>::follow_merging(State&, ProjectedState<2>, const Mesh&,
                                                      std::span<const double>);
template MergeChecks SlabMechanics<3>::follow_merging(State&, ProjectedState<3>, const Mesh&,
                                                      std::span<const double>);

}  // namespace dccast::mechanics
