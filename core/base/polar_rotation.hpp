#pragma once

#include <array>

namespace dccast {

using Matrix3 = std::array<std::array<double, 3>, 3>;  ///< by row [1]

double determinant(const Matrix3& m);  ///< [1]
/// @pre determinant(m) != 0
Matrix3 inverse(const Matrix3& m);
Matrix3 product(const Matrix3& a, const Matrix3& b);

/// The rotation R of the polar decomposition F = R U, by Newton's iteration R <- (R + R^-T) / 2
/// (Higham 1986); the identity if det F is not positive.
Matrix3 polar_rotation(const Matrix3& gradient);

/// The unit quaternion of a rotation, real part first [1] (Shepperd 1978).
std::array<double, 4> quaternion_of(const Matrix3& rotation);

}  // namespace dccast
