#pragma once

#include <array>
#include <cmath>
#include <cstddef>

// As in instructions.hpp: tensors of lanes are passed by value only between functions that are
// compiled for the same instruction set.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dccast {

/// A symmetric 3x3 tensor of a plane-strain or axisymmetric (Dim 2: xx, yy, zz, xy; zz around the
/// axis) or solid (Dim 3: xx, yy, zz, xy, yz, xz) problem. The out-of-plane normal component is
/// always kept: it belongs to the deviator and to the norm, as in the paper.
/// @tparam Number  double, or Lanes for the tensors of several points
template <int Dim, class Number = double>
struct SymmetricTensor {
  static constexpr std::size_t components = Dim == 2 ? 4 : 6;
  std::array<Number, components> value{};  ///< in the order named above

  Number& operator[](std::size_t i) { return value[i]; }
  const Number& operator[](std::size_t i) const { return value[i]; }

  /// Sum of the normal components, in the unit of the tensor.
  Number trace() const { return value[0] + value[1] + value[2]; }
  /// The tensor without its mean normal component.
  SymmetricTensor deviator() const {
    SymmetricTensor d = *this;
    const Number mean = trace() / 3.0;
    for (std::size_t i = 0; i < 3; ++i) d.value[i] -= mean;
    return d;
  }
  /// Double contraction t : t, in the square of the unit.
  Number squared_norm() const {
    Number normal{}, shear{};
    for (std::size_t i = 0; i < 3; ++i) normal += value[i] * value[i];
    for (std::size_t i = 3; i < components; ++i) shear += value[i] * value[i];
    return normal + 2.0 * shear;
  }
  /// Frobenius norm |t| = sqrt(t : t), in the unit of the tensor.
  double norm() const { return std::sqrt(squared_norm()); }
  /// Adds `factor` times another tensor.
  SymmetricTensor& add(const Number& factor, const SymmetricTensor& other) {
    for (std::size_t i = 0; i < components; ++i) value[i] += factor * other.value[i];
    return *this;
  }
  /// Adds `mean` times the identity tensor.
  SymmetricTensor& add_identity(const Number& mean) {
    for (std::size_t i = 0; i < 3; ++i) value[i] += mean;
    return *this;
  }
  /// Component (a, b) of the symmetric tensor, a and b below Dim.
  const Number& at(std::size_t a, std::size_t b) const { return value[index(a, b)]; }
  /// Place of component (a, b) in `value`.
  static constexpr std::size_t index(std::size_t a, std::size_t b) {
    constexpr std::size_t table[3][3] = {{0, 3, 5}, {3, 1, 4}, {5, 4, 2}};
    return table[a][b];
  }
};

/// A general 3x3 matrix by rows, in the unit of its use.
using Matrix3 = std::array<std::array<double, 3>, 3>;

/// Determinant, in the cube of the unit.
double determinant(const Matrix3& m);
/// Inverse matrix, in the reciprocal unit. @pre determinant(m) != 0
Matrix3 inverse(const Matrix3& m);
/// Matrix product a b.
Matrix3 product(const Matrix3& a, const Matrix3& b);

/// The rotation R of the polar decomposition F = R U, by Newton's iteration R <- (R + R^-T) / 2
/// (Higham 1986); the identity if det F is not positive. @param gradient  F [1]
Matrix3 polar_rotation(const Matrix3& gradient);

/// The unit quaternion of a rotation, real part first [1] (Shepperd 1978).
/// @param rotation  orthogonal, with determinant 1 [1]
std::array<double, 4> quaternion_of(const Matrix3& rotation);

}  // namespace dccast
