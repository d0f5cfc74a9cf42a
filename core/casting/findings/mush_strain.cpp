#include "core/casting/findings/mush_strain.hpp"

#include <algorithm>
#include <cmath>

#include "core/casting/findings/motion.hpp"

namespace dccast::casting {

double largest_principal(const SymmetricTensor<2>& t) {
  return 0.5 * (t[0] + t[1]) + std::hypot(0.5 * (t[0] - t[1]), t[3]);
}

/// Closed form by the Lode angle, from the third invariant of the deviator.
double largest_principal(const SymmetricTensor<3>& t) {
  const double mean = t.trace() / 3.0;
  const SymmetricTensor<3> s = t.deviator();
  const double radius = s.norm() / std::sqrt(6.0);
  if (radius == 0.0) return mean;

  const double determinant = s[0] * (s[1] * s[2] - s[4] * s[4]) -
                             s[3] * (s[3] * s[2] - s[4] * s[5]) +
                             s[5] * (s[3] * s[4] - s[1] * s[5]);
  const double cosine = std::clamp(0.5 * determinant / std::pow(radius, 3), -1.0, 1.0);
  return mean + 2.0 * radius * std::cos(std::acos(cosine) / 3.0);
}

template <int Dim>
Located<Dim> mush_strain(const mesh::Mesh<Dim>& mesh, const mechanics::SlabState<Dim>& slab,
                         std::span<const double> temperature, double fragile_above, int growing,
                         bool hoop) {
  Located<Dim> largest;
  if (!slab.started || mesh.elements() == 0) return largest;

  int strained_element = -1;
  const std::size_t points = slab.viscoplastic.size() / std::size_t(mesh.elements());
  for (int e = 0; e < growing; ++e) {
    if (slab.solid[std::size_t(e)] == 0) continue;
    if (temperature[std::size_t(e)] <= fragile_above) continue;

    for (std::size_t q = 0; q < points; ++q) {
      const auto& tensor = slab.viscoplastic[std::size_t(e) * points + q];
      double strain = largest_principal(tensor);
      // By symmetry the hoop direction of a billet is a principal one.
      if (Dim == 2 && hoop) strain = std::max(strain, tensor[2]);
      if (strain <= largest.value) continue;
      largest.value = strain;
      strained_element = e;
    }
  }

  if (strained_element >= 0)
    std::ranges::copy(centroid(mesh, strained_element), largest.place.begin());
  return largest;
}

template Located<2> mush_strain(const mesh::Mesh<2>&, const mechanics::SlabState<2>&,
                                std::span<const double>, double, int, bool);
template Located<3> mush_strain(const mesh::Mesh<3>&, const mechanics::SlabState<3>&,
                                std::span<const double>, double, int, bool);

}  // namespace dccast::casting
