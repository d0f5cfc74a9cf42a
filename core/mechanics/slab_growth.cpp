// Transfer of the state of a slab to a changed mesh: growth and merged rows.
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "core/mechanics/rows_of_points.hpp"
#include "core/mechanics/slab_mechanics.hpp"

namespace dccast::mechanics {

namespace {

/// Elastic strains including the thermal part, for the points of the elements from `first` on [1].
/// @param displacement  by unknown [m], which has set the rotations of the forms
template <int Dim>
std::vector<SymmetricTensor<Dim>> elastic_strains(const MechanicsForms<Dim>& forms,
                                                  const SlabState<Dim>& state,
                                                  std::span<const double> displacement,
                                                  std::size_t first = 0) {
  const std::size_t points = forms.points();
  std::vector<SymmetricTensor<Dim>> elastic;
  for (std::size_t e = first; e < forms.elements(); ++e) {
    const auto strains = forms.strains(e, displacement);
    for (std::size_t q = 0; q < points; ++q) {
      elastic.push_back(strains[q]);
      elastic.back().add(-1.0, state.inelastic[e * points + q]);
    }
  }
  return elastic;
}

/// Sets the inelastic strains of the elements from `first` on such that the elastic strains are the
/// given ones; zero for points beyond these.
template <int Dim>
void set_elastic_strains(const MechanicsForms<Dim>& forms, SlabState<Dim>& state,
                         std::span<const double> displacement,
                         const std::vector<SymmetricTensor<Dim>>& elastic, std::size_t first = 0) {
  const std::size_t points = forms.points();
  for (std::size_t e = first; e < forms.elements(); ++e) {
    const auto strains = forms.strains(e, displacement);
    for (std::size_t q = 0; q < points; ++q) {
      const std::size_t i = e * points + q, known = i - first * points;
      state.inelastic[i] = strains[q];
      if (known < elastic.size()) state.inelastic[i].add(-1.0, elastic[known]);
    }
  }
}

}  // namespace

template <int Dim>
void SlabMechanics<Dim>::follow_growth(State& state, const Mesh& grown, int nodes_per_row,
                                       int first_moved) {
  const std::size_t first = std::size_t(first_moved);
  const int old_nodes = static_cast<int>(state.displacement.size()) / Dim;
  std::vector<double> u = supports_.by_unknown(state.displacement);
  set_rotations(u, state.carries);
  const std::vector<Tensor> elastic = elastic_strains(*forms_, state, u, first);

  const std::size_t stride = std::size_t(nodes_per_row) * Dim;
  for (std::size_t i = state.displacement.size(); i < std::size_t(grown.nodes()) * Dim; ++i) {
    state.displacement.push_back(state.displacement[i - stride]);
  }

  state.leaning.resize(state.displacement.size(), 1);
  state.solid.resize(std::size_t(grown.elements()), 0);
  state.carries.resize(std::size_t(grown.elements()), 0);
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
  set_rotations(u, state.carries);
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
  set_rotations(u, state.carries);
  std::vector<Tensor> elastic = elastic_strains(*forms_, state, u);
  std::vector<double> dilatation;  // one of an element, as its pressure
  for (Tensor& strain : elastic) {
    dilatation.push_back(strain.trace());
    strain = strain.deviator();
  }

  ProjectedState<Dim> to{state, rows.projected(elastic),
                         rows.restricted(forces_of_stress(state).nodal),
                         whole_weight(state, temperature)};
  dilatation = rows.means(dilatation);
  for (std::size_t i = 0; i < dilatation.size(); ++i)
    to.elastic[i].add_identity(dilatation[i] / 3.0);

  to.state.viscoplastic = rows.projected(state.viscoplastic);
  to.state.deviator = rows.projected(state.deviator);
  to.state.pressure = rows.means(state.pressure);
  if (!state.hardened.empty()) to.state.hardened = rows.point_means(state.hardened);
  to.state.solid = rows.all_of(state.solid);
  to.state.carries = rows.all_of(state.carries);
  for (std::size_t i = 0; i < to.elastic.size(); ++i)
    if (to.state.carries[i / points_] == 0 && rows.is_pair(i / points_)) to.elastic[i] = {};

  mesh::take_out_rows(merged, merged.nodes_per_row * Dim, to.state.displacement);
  mesh::take_out_rows(merged, merged.nodes_per_row * Dim, to.state.leaning);
  return to;
}

template <int Dim>
MergeChecks SlabMechanics<Dim>::follow_merging(State& state, ProjectedState<Dim> projected,
                                               const Mesh& merged_mesh,
                                               std::span<const double> temperature) {
  state = std::move(projected.state);
  set_mesh(merged_mesh);
  const std::vector<double> u = supports_.by_unknown(state.displacement);
  set_rotations(u, state.carries);
  state.inelastic.resize(projected.elastic.size());
  set_elastic_strains(*forms_, state, u, projected.elastic);
  const double weight = whole_weight(state, temperature);
  double squares = 0.0;
  const auto [force, acting] = forces_of_stress(state);
  for (std::size_t i = 0; i < force.size(); ++i)
    squares += (force[i] - projected.force[i]) * (force[i] - projected.force[i]);
  return {std::abs(weight - projected.weight) / projected.weight,
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
