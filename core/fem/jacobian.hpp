#pragma once

#include <array>
#include <cstddef>

#include "core/fem/element.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::fem {

/// Derivatives of position with respect to the reference coordinates at a point of an element.
template <int Dim>
class Jacobian {
public:
  /// @param reference  (node) derivatives of the shape functions by the reference coordinates [1]
  template <std::size_t Nodes>
  Jacobian(const mesh::Mesh<Dim>& mesh, const int* node,
           const std::array<std::array<double, Dim>, Nodes>& reference) {
    for (std::size_t i = 0; i < Nodes; ++i) {
      const double* x = mesh.point(node[i]);
      for (std::size_t a = 0; a < Dim; ++a) {
        for (std::size_t b = 0; b < Dim; ++b) derivative_[a][b] += x[a] * reference[i][b];
      }
    }
    set_cofactors();
  }

  /// [m^Dim], positive if the element is positively oriented.
  double determinant() const {
    double sum = derivative_[0][0] * cofactor_[0][0];
    for (std::size_t b = 1; b < Dim; ++b) sum += derivative_[0][b] * cofactor_[0][b];
    return sum;
  }

  /// Spatial gradient of a function [1/m].
  /// @param reference  its gradient by the reference coordinates [1]
  /// @param inverse    1 / determinant() [m^-Dim]
  std::array<double, Dim> gradient(const std::array<double, Dim>& reference, double inverse) const {
    std::array<double, Dim> g;
    for (std::size_t a = 0; a < Dim; ++a) {
      double sum = cofactor_[a][0] * reference[0];
      for (std::size_t b = 1; b < Dim; ++b) sum += cofactor_[a][b] * reference[b];
      g[a] = inverse * sum;
    }
    return g;
  }

private:
  /// Cofactors: the inverse is their transpose divided by the determinant.
  void set_cofactors() {
    const auto& d = derivative_;
    if constexpr (Dim == 2) {
      cofactor_ = {{{d[1][1], -d[1][0]}, {-d[0][1], d[0][0]}}};
    } else {
      for (std::size_t a = 0; a < 3; ++a) {
        const std::size_t a1 = (a + 1) % 3, a2 = (a + 2) % 3;
        for (std::size_t b = 0; b < 3; ++b) {
          const std::size_t b1 = (b + 1) % 3, b2 = (b + 2) % 3;
          cofactor_[a][b] = d[a1][b1] * d[a2][b2] - d[a1][b2] * d[a2][b1];
        }
      }
    }
  }

  std::array<std::array<double, Dim>, Dim> derivative_{};  ///< (coordinate, reference) [m]
  std::array<std::array<double, Dim>, Dim> cofactor_;      ///< [m^(Dim-1)]
};

/// Reference coordinates of the nodes of an element [1].
template <class Element>
constexpr std::array<std::array<double, Element::dimension>, Element::nodes> reference_corners() {
  constexpr std::size_t dim = Element::dimension, nodes = Element::nodes;
  std::array<std::array<double, dim>, nodes> corner{};
  for (std::size_t i = 0; i < nodes; ++i) {
    for (std::size_t a = 0; a < dim; ++a) {
      if constexpr (nodes == dim + 1) {
        corner[i][a] = i == a + 1 ? 1.0 : 0.0;
      } else {
        corner[i][a] = detail::corner[i][a];
      }
    }
  }
  return corner;
}

}  // namespace dccast::fem
