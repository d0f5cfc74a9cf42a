#include "core/thermal/conduction.hpp"

#include <algorithm>
#include <array>

#include "core/fem/element.hpp"

namespace dccast::thermal {
namespace {

using mesh::Mesh2D;
using mesh::SectionKind;

template <class Element>
struct Corners;
template <>
struct Corners<fem::P1Triangle> {
  static constexpr std::array<std::array<double, 2>, 3> at{{{0, 0}, {1, 0}, {0, 1}}};
};
template <>
struct Corners<fem::Q1Quadrilateral> {
  static constexpr std::array<std::array<double, 2>, 4> at{{{-1, -1}, {1, -1}, {1, 1}, {-1, 1}}};
};

/// Derivatives of x (first row) and y with respect to the reference coordinates.
struct Jacobian {
  double xa = 0.0, xb = 0.0, ya = 0.0, yb = 0.0;
  double determinant() const { return xa * yb - xb * ya; }
};

template <class Element>
Jacobian jacobian_at(const Mesh2D& mesh, const int* node, const std::array<double, 2>& reference) {
  const auto gradient = Element::shape_gradient(reference);
  Jacobian j;
  for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) {
    const double* x = mesh.point(node[i]);
    j.xa += x[0] * gradient[i][0];
    j.xb += x[0] * gradient[i][1];
    j.ya += x[1] * gradient[i][0];
    j.yb += x[1] * gradient[i][1];
  }
  return j;
}

/// Integral of each shape function over the element, times the radius in an axisymmetric section.
template <class Element>
std::array<double, Element::nodes> corner_volumes(const Mesh2D& mesh, SectionKind kind,
                                                  const int* node) {
  std::array<double, Element::nodes> volume{};
  const bool round = kind == SectionKind::axisymmetric;
  if constexpr (Element::nodes == 3) {
    // Exact: integral of N_i N_j is A/12, of N_i^2 A/6.
    const double area = 0.5 * jacobian_at<Element>(mesh, node, {0.0, 0.0}).determinant();
    double radii = 0.0;
    for (int i = 0; i < 3; ++i) radii += mesh.point(node[i])[0];
    for (std::size_t i = 0; i < 3; ++i) {
      volume[i] = round ? area / 12.0 * (radii + mesh.point(node[i])[0]) : area / 3.0;
    }
  } else {
    for (std::size_t q = 0; q < std::size_t(Element::points); ++q) {
      const auto shape = Element::shape(Element::point[q]);
      double radius = round ? 0.0 : 1.0;
      for (std::size_t i = 0; round && i < std::size_t(Element::nodes); ++i) {
        radius += shape[i] * mesh.point(node[i])[0];
      }
      const double weight = Element::weight[q] * radius *
                            jacobian_at<Element>(mesh, node, Element::point[q]).determinant();
      for (std::size_t i = 0; i < std::size_t(Element::nodes); ++i) volume[i] += weight * shape[i];
    }
  }
  return volume;
}

/// Calls `use(element, corner volumes)` for every element, whichever kind the mesh is made of.
template <class Use>
void for_each_volume(const Mesh2D& mesh, SectionKind kind, const Use& use) {
  for (int e = 0; e < mesh.elements(); ++e) {
    if (mesh.nodes_per_element == 3) {
      use(e, corner_volumes<fem::P1Triangle>(mesh, kind, mesh.nodes_of(e)));
    } else {
      use(e, corner_volumes<fem::Q1Quadrilateral>(mesh, kind, mesh.nodes_of(e)));
    }
  }
}

}  // namespace

std::vector<double> nodal_volumes(const Mesh2D& mesh, SectionKind kind) {
  std::vector<double> volume(std::size_t(mesh.nodes()), 0.0);
  for_each_volume(mesh, kind, [&](int e, const auto& corner) {
    for (std::size_t i = 0; i < corner.size(); ++i) {
      volume[std::size_t(mesh.nodes_of(e)[i])] += corner[i];
    }
  });
  return volume;
}

bool Conduction::set_mesh(const Mesh2D& mesh, SectionKind kind) {
  const bool changed = element_node_ != mesh.element_node || volume_.empty();
  if (changed) {
    element_node_ = mesh.element_node;
    pattern_ = linalg::SparsityPattern(mesh.nodes(), element_node_, mesh.nodes_per_element);
    stiffness_.resize(pattern_.entries());
    volume_.resize(std::size_t(mesh.nodes()));
  }
  std::fill(stiffness_.begin(), stiffness_.end(), 0.0);
  std::fill(volume_.begin(), volume_.end(), 0.0);
  if (mesh.nodes_per_element == 3) {
    integrate<fem::P1Triangle>(mesh, kind);
  } else {
    integrate<fem::Q1Quadrilateral>(mesh, kind);
  }
  return changed;
}

template <class Element>
void Conduction::integrate(const Mesh2D& mesh, SectionKind kind) {
  constexpr std::size_t corners = Element::nodes;
  for (int e = 0; e < mesh.elements(); ++e) {
    const int* node = mesh.nodes_of(e);
    const int* place = pattern_.places(e);
    const auto corner_volume = corner_volumes<Element>(mesh, kind, node);
    for (std::size_t i = 0; i < corners; ++i) volume_[std::size_t(node[i])] += corner_volume[i];
    for (std::size_t c = 0; c < corners; ++c) {
      const auto reference = Element::shape_gradient(Corners<Element>::at[c]);
      const Jacobian j = jacobian_at<Element>(mesh, node, Corners<Element>::at[c]);
      const double inverse = 1.0 / j.determinant();
      std::array<std::array<double, 2>, corners> gradient;
      for (std::size_t i = 0; i < corners; ++i) {
        gradient[i] = {inverse * (j.yb * reference[i][0] - j.ya * reference[i][1]),
                       inverse * (j.xa * reference[i][1] - j.xb * reference[i][0])};
      }
      for (std::size_t i = 0; i < corners; ++i) {
        for (std::size_t k = 0; k <= i; ++k) {
          stiffness_[std::size_t(place[i * corners + k])] +=
              corner_volume[c] *
              (gradient[i][0] * gradient[k][0] + gradient[i][1] * gradient[k][1]);
        }
      }
    }
  }
}

}  // namespace dccast::thermal
