#include "core/casting/findings/residual_stress.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/casting/findings/element_centre.hpp"
#include "core/casting/findings/mush_strain.hpp"

namespace dccast::casting {

namespace {

/// Components of the axial stress and of that along the face.
template <int Dim>
constexpr std::size_t axial = Dim == 2 ? 1 : 2;
template <int Dim>
constexpr std::size_t along_face = Dim == 2 ? 2 : 0;

/// Coordinate of the path from the symmetry plane to the face.
template <int Dim>
constexpr std::size_t inward = Dim == 2 ? 0 : 1;

template <int Dim>
double greatest_principal(const SymmetricTensor<Dim>& stress) {
  const double principal = largest_principal(stress);
  // The third direction of a section is a principal one, too.
  return Dim == 2 ? std::max(principal, stress[2]) : principal;
}

/// An element with its mean stress.
template <int Dim>
struct StressedElement {
  ElementCentre<Dim> centre;
  SymmetricTensor<Dim> stress;  ///< [Pa]
};

/// The elements at half the height, in a solid those beside the plane x = 0, from the face inwards.
template <int Dim>
std::vector<StressedElement<Dim>> path_inwards(const mesh::Mesh<Dim>& mesh,
                                               std::span<const StressedElement<Dim>> elements) {
  const double middle = 0.5 * mesh.largest(Dim - 1);
  const auto distance = [&](const StressedElement<Dim>& e) {
    return std::hypot(e.centre.place[Dim - 1] - middle, Dim == 3 ? e.centre.place[0] : 0.0);
  };

  // Elements of one row and layer have the same distance.
  constexpr double same = 1e-6;  // [m]
  const double least = distance(*std::ranges::min_element(elements, {}, distance));
  std::vector<StressedElement<Dim>> path;
  for (const auto& e : elements)
    if (distance(e) <= least + same) path.push_back(e);

  std::ranges::sort(path, std::greater<>(),
                    [](const auto& e) { return e.centre.place[inward<Dim>]; });
  return path;
}

}  // namespace

std::optional<double> find_sign_change(std::span<const StressAtDepth> path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    const StressAtDepth &a = path[i - 1], &b = path[i];
    if (a.stress * b.stress > 0.0 || a.stress == b.stress) continue;
    return a.depth + (b.depth - a.depth) * a.stress / (a.stress - b.stress);
  }
  return std::nullopt;
}

template <int Dim>
ResidualStress residual_stress(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                               const mechanics::SlabState<Dim>& slab,
                               const material::MechanicalProperties& properties, bool round) {
  ResidualStress found;
  const std::size_t points = slab.deviator.size() / std::size_t(mesh.elements());
  const double share = 1.0 / static_cast<double>(points);

  std::vector<StressedElement<Dim>> elements;
  double energy = 0.0, volume = 0.0;  // [J], [m3], of a section per metre or radian
  for (int e = 0; e < mesh.elements(); ++e) {
    StressedElement<Dim> element{centre_of(mesh, e, temperature, round), {}};
    const double shear = properties.shear_modulus(element.centre.temperature);
    const double bulk = properties.bulk_modulus(element.centre.temperature);

    // s : s / (4 mu) + p^2 / (2 K), and the mean stress.
    double density = 0.0;
    for (std::size_t q = 0; q < points; ++q) {
      const std::size_t i = std::size_t(e) * points + q;
      const double pressure = slab.pressure[i];
      density += share * (slab.deviator[i].squared_norm() / (4.0 * shear) +
                          pressure * pressure / (2.0 * bulk));
      element.stress.add(share, slab.deviator[i]).add_identity(share * pressure);
    }

    energy += density * element.centre.volume;
    volume += element.centre.volume;
    found.tension = std::max(found.tension, greatest_principal(element.stress));
    elements.push_back(element);
  }
  found.elastic_energy = energy / volume;

  const double face = mesh.largest(static_cast<int>(inward<Dim>));
  std::vector<StressAtDepth> axial_path, hoop_path;
  for (const auto& e : path_inwards<Dim>(mesh, elements)) {
    const double depth = face - e.centre.place[inward<Dim>];
    axial_path.push_back({depth, e.stress[axial<Dim>]});
    hoop_path.push_back({depth, e.stress[along_face<Dim>]});
  }
  found.axial_depth = find_sign_change(axial_path);
  found.hoop_depth = find_sign_change(hoop_path);
  return found;
}

template ResidualStress residual_stress(const mesh::Mesh<2>&, std::span<const double>,
                                        const mechanics::SlabState<2>&,
                                        const material::MechanicalProperties&, bool);
template ResidualStress residual_stress(const mesh::Mesh<3>&, std::span<const double>,
                                        const mechanics::SlabState<3>&,
                                        const material::MechanicalProperties&, bool);

}  // namespace dccast::casting
