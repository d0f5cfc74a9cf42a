#include "core/findings/bottom_shell.hpp"

#include <algorithm>
#include <utility>

#include "core/findings/edges.hpp"

namespace dccast::casting {

namespace {

template <int Dim>
Located<Dim> whole_height(const mesh::Mesh<Dim>& mesh) {
  Located<Dim> found;
  for (int n = 0; n < mesh.nodes(); ++n)
    found.value = std::max(found.value, mesh.point(n)[Dim - 1]);
  return found;
}

/// Height of the lowest node of an element [m].
template <int Dim>
double height_of(const mesh::Mesh<Dim>& mesh, int e) {
  const int* node = mesh.nodes_of(e);
  double lowest = mesh.point(node[0])[Dim - 1];
  for (int i = 1; i < mesh.nodes_per_element; ++i)
    lowest = std::min(lowest, mesh.point(node[i])[Dim - 1]);
  return lowest;
}

/// The point where an edge between a cold and a hot node crosses the isotherm.
template <int Dim>
std::array<double, Dim> crossing(const double* cold, const double* hot, double share) {
  std::array<double, Dim> at{};
  for (std::size_t d = 0; d < Dim; ++d) at[d] = cold[d] + share * (hot[d] - cold[d]);
  return at;
}

}  // namespace

template <int Dim>
Located<Dim> bottom_shell(const mesh::Mesh<Dim>& mesh, std::span<const double> temperature,
                          double isotherm) {
  Located<Dim> lowest = whole_height(mesh);
  const auto consider = [&](const std::array<double, Dim>& at) {
    if (at[Dim - 1] >= lowest.value) return;
    lowest = {at[Dim - 1], at};
    lowest.place[Dim - 1] = 0.0;
  };
  const auto edges = edges_of(Dim, mesh.nodes_per_element);
  for (int e = 0; e < mesh.elements(); ++e) {
    if (height_of(mesh, e) >= lowest.value) continue;  // most, once a place is known
    for (const auto& [i, j] : edges) {
      int cold = mesh.nodes_of(e)[i], hot = mesh.nodes_of(e)[j];
      if (temperature[std::size_t(cold)] > temperature[std::size_t(hot)]) std::swap(cold, hot);
      const double low = temperature[std::size_t(cold)], high = temperature[std::size_t(hot)];
      if (high < isotherm) continue;
      const double share = low >= isotherm ? 0.0 : (isotherm - low) / (high - low);
      consider(crossing<Dim>(mesh.point(cold), mesh.point(hot), share));
      if (low >= isotherm) consider(crossing<Dim>(mesh.point(cold), mesh.point(hot), 1.0));
    }
  }
  return lowest;
}

template Located<2> bottom_shell(const mesh::Mesh<2>&, std::span<const double>, double);
template Located<3> bottom_shell(const mesh::Mesh<3>&, std::span<const double>, double);

}  // namespace dccast::casting
