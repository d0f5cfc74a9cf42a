#include "core/linalg/line_relaxation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include "core/base/instructions.hpp"

namespace dccast::linalg {

namespace {

template <int Count>
struct FloatsOf {
  typedef float type __attribute__((vector_size(4 * Count), may_alias));
};
template <int Count>
using Floats = typename FloatsOf<Count>::type;

/// Unaligned load and store.
template <int Count>
[[gnu::always_inline]] inline Floats<Count> load(const float* from) {
  Floats<Count> x;
  __builtin_memcpy(&x, from, sizeof x);
  return x;
}
template <int Count>
[[gnu::always_inline]] inline void store(const Floats<Count>& x, float* to) {
  __builtin_memcpy(to, &x, sizeof x);
}

/// y_high -= C x_low along the rows of a pair of lines; row k couples rows k - 1 to k + 1.
template <int Count, int N>
[[gnu::always_inline]] inline void subtract(const float* c, std::size_t stride, const float* low,
                                            float* high) {
  // Count rows at a time, as one vector.
  for (std::size_t k = 0; k < stride; k += Count) {
    for (int a = 0; a < N; ++a) {
      Floats<Count> sum = load<Count>(high + std::size_t(a) * stride + k);
      for (int b = 0; b < N; ++b) {
        for (int d = 0; d < 3; ++d) {
          const float* entry = c + std::size_t((a * N + b) * 3 + d) * stride + k;
          sum -= load<Count>(entry) * load<Count>(low + std::size_t(b) * stride + k + d - 1);
        }
      }
      store<Count>(sum, high + std::size_t(a) * stride + k);
    }
  }
}

/// y_low -= C' x_high along the rows of a pair of lines.
template <int Count, int N>
[[gnu::always_inline]] inline void subtract_transposed(const float* c, std::size_t stride,
                                                       const float* high, float* low) {
  // Count rows at a time, as one vector.
  for (std::size_t k = 0; k < stride; k += Count) {
    for (int b = 0; b < N; ++b) {
      Floats<Count> sum = load<Count>(low + std::size_t(b) * stride + k);
      for (int a = 0; a < N; ++a) {
        for (int d = 0; d < 3; ++d) {
          // Row k of the low line meets row k - d + 1 of the high one.
          const float* entry = c + std::size_t((a * N + b) * 3 + d) * stride + k - d + 1;
          sum -= load<Count>(entry) * load<Count>(high + std::size_t(a) * stride + k - d + 1);
        }
      }

      store<Count>(sum, low + std::size_t(b) * stride + k);
    }
  }
}

/// Inverse of a symmetric positive definite block of three by its cofactors. @return false if it is
/// not one
bool invert(const double* m, double* inverse) {
  const double minor = m[0] * m[4] - m[1] * m[1];
  const double c0 = m[4] * m[8] - m[5] * m[5];
  const double c1 = m[2] * m[5] - m[1] * m[8];
  const double c2 = m[1] * m[5] - m[2] * m[4];
  const double determinant = m[0] * c0 + m[1] * c1 + m[2] * c2;
  const double f = 1.0 / determinant;

  inverse[0] = c0 * f;
  inverse[1] = inverse[3] = c1 * f;
  inverse[2] = inverse[6] = c2 * f;
  inverse[4] = (m[0] * m[8] - m[2] * m[2]) * f;
  inverse[5] = inverse[7] = (m[1] * m[2] - m[0] * m[5]) * f;
  inverse[8] = minor * f;

  // Sylvester's criterion: all leading minors are positive.
  return m[0] > 0.0 && minor > 0.0 && determinant > 0.0 && std::isfinite(f);
}

}  // namespace

template <int N>
void LineRelaxation<N>::start(const LineLayout<N>& layout) {
  layout_ = &layout;
  const std::size_t pair_size = std::size_t(LineLayout<N>::entries) * layout.stride();
  own_.assign(std::size_t(layout.lines()) * pair_size, 0.0);
  coupling_.assign(2 * guard + layout.pairs() * pair_size, 0.0F);
  step_.resize(std::size_t(layout.lines()) * std::size_t(layout.rows()));
}

template <int N>
void LineRelaxation<N>::add(const typename LineLayout<N>::Place& place, const double* block) {
  const auto slot = layout_->block(place);
  for (int a = 0; a < N; ++a) {
    for (int b = 0; b < N; ++b) {
      if (place.one_line) {
        own_[slot(a, b)] += block[a * N + b];
      } else {
        coupling_[guard + slot(a, b)] += static_cast<float>(block[a * N + b]);
      }
    }
  }
}

template <int N>
bool LineRelaxation<N>::factorize() {
  bool positive = true;
  for (int line = 0; line < layout_->lines(); ++line) positive = factorize_line(line) && positive;
  return positive;
}

template <int N>
bool LineRelaxation<N>::factorize_line(int line) {
  std::array<double, square> pivot{}, inverse{}, below{};
  Step* step = &step_[std::size_t(line) * std::size_t(layout_->rows())];
  for (int k = 0; k < layout_->rows(); ++k) {
    const auto own = layout_->block(layout_->place(line, k, line, k));
    for (int a = 0; a < N; ++a) {
      for (int b = 0; b < N; ++b) pivot[std::size_t(a * N + b)] = own_[own(a, b)];
    }

    // below = E inverse(k - 1), and pivot = own block - below E', E the block under the node.
    below.fill(0.0);
    if (k > 0) {
      const auto under = layout_->block(layout_->place(line, k, line, k - 1));
      const auto e = [&](int a, int b) { return own_[under(a, b)]; };
      for (int a = 0; a < N; ++a) {
        for (int b = 0; b < N; ++b) {
          for (int c = 0; c < N; ++c) {
            below[std::size_t(a * N + b)] += e(a, c) * inverse[std::size_t(c * N + b)];
          }
        }
      }

      for (int a = 0; a < N; ++a) {
        for (int b = 0; b < N; ++b) {
          for (int c = 0; c < N; ++c) {
            pivot[std::size_t(a * N + b)] -= below[std::size_t(a * N + c)] * e(b, c);
          }
        }
      }
    }

    if (!invert(pivot.data(), inverse.data())) return false;
    for (std::size_t i = 0; i < square; ++i) {
      step[k].inverse[i] = static_cast<float>(inverse[i]);
      step[k].below[i] = static_cast<float>(below[i]);
    }
  }
  return true;
}

template <int N>
[[gnu::always_inline]] inline void LineRelaxation<N>::solve_line(int line, const float* b,
                                                                 float* x) const {
  const std::size_t stride = layout_->stride();
  const int rows = layout_->rows();
  const Step* step = &step_[std::size_t(line) * std::size_t(rows)];

  // Forward substitution, upwards.
  float last[N] = {};
  for (int k = 0; k < rows; ++k) {
    float now[N];
    for (int a = 0; a < N; ++a) {
      now[a] = b[std::size_t(a) * stride + std::size_t(k)];
      for (int c = 0; c < N; ++c) now[a] -= step[k].below[a * N + c] * last[c];
    }
    for (int a = 0; a < N; ++a) {
      last[a] = now[a];
      x[std::size_t(a) * stride + std::size_t(k)] = now[a];
    }
  }

  // Backward substitution, downwards.
  for (int a = 0; a < N; ++a) last[a] = 0.0F;
  for (int k = rows - 1; k >= 0; --k) {
    float now[N];
    for (int a = 0; a < N; ++a) {
      now[a] = 0.0F;
      for (int c = 0; c < N; ++c) {
        now[a] += step[k].inverse[a * N + c] * x[std::size_t(c) * stride + std::size_t(k)];
        if (k + 1 < rows) now[a] -= step[k + 1].below[c * N + a] * last[c];
      }
    }
    for (int a = 0; a < N; ++a) {
      last[a] = now[a];
      x[std::size_t(a) * stride + std::size_t(k)] = now[a];
    }
  }
}

template <int N>
void LineRelaxation<N>::forward(const std::vector<float>& b, std::vector<float>& x,
                                std::vector<float>& residual) const {
  const std::size_t stride = layout_->stride(), pair_size = LineLayout<N>::entries * stride;
  std::fill(residual.begin(), residual.end(), 0.0F);
  with_lanes([&]<int Count>() {
    std::vector<float> right(N * stride);
    for (int line = 0; line < layout_->lines(); ++line) {
      const std::size_t here = first_row(line, 0);
      std::memcpy(right.data(), &b[here], right.size() * sizeof(float));

      // The lower lines are solved: subtract their part.
      const std::size_t first = layout_->first_pair(line), end = layout_->first_pair(line + 1);
      for (std::size_t p = first; p < end; ++p) {
        const float* c = &coupling_[guard + p * pair_size];
        subtract<2 * Count, N>(c, stride, &x[first_row(layout_->low_line(p), 0)], right.data());
      }
      solve_line(line, right.data(), &x[here]);

      // The lower lines were solved without this one: that is their residual.
      for (std::size_t p = first; p < end; ++p) {
        const float* c = &coupling_[guard + p * pair_size];
        subtract_transposed<2 * Count, N>(c, stride, &x[here],
                                          &residual[first_row(layout_->low_line(p), 0)]);
      }
    }
  });
}

template <int N>
void LineRelaxation<N>::backward(std::vector<float>& b, std::vector<float>& x) const {
  const std::size_t stride = layout_->stride(), pair_size = LineLayout<N>::entries * stride;
  with_lanes([&]<int Count>() {
    for (int line = layout_->lines() - 1; line >= 0; --line) {
      const std::size_t here = first_row(line, 0);

      // The forward solution of the lower lines; the higher ones have subtracted theirs from b.
      const std::size_t first = layout_->first_pair(line), end = layout_->first_pair(line + 1);
      for (std::size_t p = first; p < end; ++p) {
        const float* c = &coupling_[guard + p * pair_size];
        subtract<2 * Count, N>(c, stride, &x[first_row(layout_->low_line(p), 0)], &b[here]);
      }

      solve_line(line, &b[here], &x[here]);
      for (std::size_t p = first; p < end; ++p) {
        const float* c = &coupling_[guard + p * pair_size];
        subtract_transposed<2 * Count, N>(c, stride, &x[here],
                                          &b[first_row(layout_->low_line(p), 0)]);
      }
    }
  });
}

template <int N>
std::size_t LineRelaxation<N>::memory_bytes() const {
  return own_.size() * sizeof(double) + coupling_.size() * sizeof(float) +
         step_.size() * sizeof(Step);
}

template class LineRelaxation<3>;

}  // namespace dccast::linalg
