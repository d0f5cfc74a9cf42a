#include "core/casting/findings/pores.hpp"

#include <utility>
#include <vector>

#include "core/casting/findings/element_centre.hpp"
#include "core/material/mechanical_properties.hpp"

namespace dccast::casting {

namespace {

/// The share of pores between the solidus, below which it no longer changes, and coalescence.
Curve tabulate(const material::AlloyCard& card) {
  constexpr int parts = 200;
  const material::MechanicalProperties properties(card);
  const double low = card.solidus, high = properties.coalescence();
  if (high <= low) return Curve(properties.pore_share(low));

  std::vector<double> at, share;
  for (int i = 0; i <= parts; ++i) {
    at.push_back(low + (high - low) * i / parts);
    share.push_back(properties.pore_share(at.back()));
  }
  return Curve(Abscissa::temperature, std::move(at), std::move(share));
}

}  // namespace

Pores::Pores(const material::AlloyCard& card, mesh::SectionKind section)
    : round_(section == mesh::SectionKind::axisymmetric) {
  if (card.mush) share_ = tabulate(card);
}

template <int Dim>
double Pores::volume(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature) const {
  double volume = 0.0;
  if (share_.empty()) return volume;
  for (int e = 0; e < mesh.elements(); ++e) {
    const double share = share_(mesh::mean_at_nodes(mesh, e, temperature));
    if (share > 0.0) volume += share * centre_of(mesh, e, temperature, round_).volume;
  }
  return volume;
}

template double Pores::volume(const mesh::Mesh<2>&, std::span<const double>) const;
template double Pores::volume(const mesh::Mesh<3>&, std::span<const double>) const;

}  // namespace dccast::casting
