#include "core/base/tensors.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace dccast {

namespace {

constexpr Matrix3 identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

// Signed cofactor of entry (r, c): cyclic indices give the sign.
double cofactor(const Matrix3& m, std::size_t r, std::size_t c) {
  const std::size_t r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
  return m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
}

}  // namespace

double determinant(const Matrix3& m) {
  return m[0][0] * cofactor(m, 0, 0) + m[0][1] * cofactor(m, 0, 1) + m[0][2] * cofactor(m, 0, 2);
}

Matrix3 inverse(const Matrix3& m) {
  const double divisor = determinant(m);
  Matrix3 result;
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t c = 0; c < 3; ++c) result[c][r] = cofactor(m, r, c) / divisor;
  return result;
}

Matrix3 product(const Matrix3& a, const Matrix3& b) {
  Matrix3 result{};
  for (std::size_t r = 0; r < 3; ++r)
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t c = 0; c < 3; ++c) result[r][c] += a[r][k] * b[k][c];
  return result;
}

Matrix3 polar_rotation(const Matrix3& gradient) {
  if (!(determinant(gradient) > 0.0)) return identity;

  constexpr int most_iterations = 50;  // quadratic convergence once the stretches are near 1
  constexpr double round_off = 1e-15;
  Matrix3 rotation = gradient;
  for (int i = 0; i < most_iterations; ++i) {
    const Matrix3 inverted = inverse(rotation);
    double change = 0.0;
    for (std::size_t r = 0; r < 3; ++r) {
      for (std::size_t c = 0; c < 3; ++c) {
        const double next = 0.5 * (rotation[r][c] + inverted[c][r]);
        change = std::max(change, std::abs(next - rotation[r][c]));
        rotation[r][c] = next;
      }
    }

    if (change <= round_off) break;
  }
  return rotation;
}

std::array<double, 4> quaternion_of(const Matrix3& m) {
  // Of the four squares of the components the root of the largest is taken: this avoids
  // cancellation.
  const double trace = m[0][0] + m[1][1] + m[2][2];
  const std::array<double, 4> squares{trace, m[0][0], m[1][1], m[2][2]};
  const auto largest =
      static_cast<std::size_t>(std::max_element(squares.begin(), squares.end()) - squares.begin());

  std::array<double, 4> q{};
  if (largest == 0) {
    q = {1.0 + trace, m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]};
  } else {
    const std::size_t i = largest - 1, j = (i + 1) % 3, k = (i + 2) % 3;
    q[0] = m[k][j] - m[j][k];
    q[1 + i] = 1.0 + m[i][i] - m[j][j] - m[k][k];
    q[1 + j] = m[j][i] + m[i][j];
    q[1 + k] = m[k][i] + m[i][k];
  }

  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& part : q) part /= norm;
  return q;
}

}  // namespace dccast
