#include <Eigen/Cholesky>
#include <algorithm>
#include <new>

#include "core/linalg/cholmod_factor.hpp"
#include "core/linalg/contact_factor.hpp"

namespace dccast::linalg {

struct TrailingFactor::Storage : CholmodFactor {
  Storage(const SparsityPattern& p, std::vector<int> unknowns)
      : CholmodFactor(p), pattern(p), last(std::move(unknowns)) {
    order_last();
    const auto* order = static_cast<const int*>(factor->Perm);
    first = factor->n - last.size();
    std::copy_n(order + first, last.size(), last.begin());
  }

  void order_last() {
    std::vector<int> group(matrix.nrow, 0), order(matrix.nrow);
    for (const int u : last) group[std::size_t(u)] = 1;
    cholmod_camd(&matrix, nullptr, 0, group.data(), order.data(), &common);
    common.method[0].ordering = CHOLMOD_GIVEN;
    common.postorder = 0;  // it could move a contact unknown forward
    choose_kind();
    factor = cholmod_analyze_p(&matrix, order.data(), nullptr, 0, &common);
    if (factor == nullptr) throw std::bad_alloc();
  }

  /// The last rows and columns of L and D from either kind of factor.
  void read_trailing() {
    const Eigen::Index m = static_cast<Eigen::Index>(last.size());
    lower = Eigen::MatrixXd::Zero(m, m);
    diagonal.assign(factor->n, 1.0);
    factor->is_super != 0 ? read_supernodal() : read_simplicial();
  }
  void put(std::size_t row, std::size_t column, double value) {
    if (column >= first) lower(Eigen::Index(row - first), Eigen::Index(column - first)) = value;
  }
  void read_simplicial() {
    const auto* start = static_cast<const int*>(factor->p);
    const auto* count = static_cast<const int*>(factor->nz);
    const auto* row = static_cast<const int*>(factor->i);
    const auto* value = static_cast<const double*>(factor->x);
    for (std::size_t c = 0; c < factor->n; ++c) {
      diagonal[c] = value[start[c]];
      put(c, c, 1.0);
      for (int k = start[c] + 1; c >= first && k < start[c] + count[c]; ++k) {
        put(std::size_t(row[k]), c, value[k]);
      }
    }
  }
  void read_supernodal() {
    const auto* column = static_cast<const int*>(factor->super);
    const auto* rows = static_cast<const int*>(factor->pi);
    const auto* block = static_cast<const int*>(factor->px);
    const auto* row = static_cast<const int*>(factor->s);
    const auto* value = static_cast<const double*>(factor->x);
    for (std::size_t s = 0; s < factor->nsuper; ++s) {
      const int height = rows[s + 1] - rows[s];
      for (int c = column[s]; c < column[s + 1]; ++c) {
        const int from = c - column[s];
        for (int i = from; std::size_t(c) >= first && i < height; ++i) {
          put(std::size_t(row[rows[s] + i]), std::size_t(c), value[block[s] + from * height + i]);
        }
      }
    }
  }

  const SparsityPattern& pattern;
  std::vector<int> last;         ///< in the order of the factor
  std::size_t first = 0;         ///< place of the first of them there
  Eigen::MatrixXd lower;         ///< trailing part of L
  std::vector<double> diagonal;  ///< D by place; ones where L L' is kept
  Eigen::MatrixXd schur;         ///< of the contact unknowns, all free
  std::vector<Eigen::Index> free;
  Eigen::LLT<Eigen::MatrixXd> dense;
  std::vector<double> right;
  std::vector<char> outside;  ///< held unknowns other than `last`
};

TrailingFactor::TrailingFactor(const SparsityPattern& pattern, std::vector<int> last)
    : storage_(std::make_unique<Storage>(pattern, std::move(last))) {}
TrailingFactor::~TrailingFactor() = default;

bool TrailingFactor::factorize(std::span<const double> values, std::span<const char> held) {
  Storage& s = *storage_;
  s.outside.assign(held.begin(), held.end());
  for (const int u : s.last) s.outside[std::size_t(u)] = 0;
  empty_held(s.pattern, values, s.outside, s.masked);
  // With no contact unknown held K may be singular: each stands on a spring that S loses again.
  for (const int u : s.last) s.masked[std::size_t(s.pattern.diagonal(u))] *= 2.0;
  if (!s.CholmodFactor::factorize()) return false;
  s.read_trailing();
  const Eigen::Map<const Eigen::VectorXd> d(s.diagonal.data() + s.first,
                                            Eigen::Index(s.last.size()));
  s.schur = s.lower * d.asDiagonal() * s.lower.transpose();
  for (std::size_t i = 0; i < s.last.size(); ++i) {
    s.schur(Eigen::Index(i), Eigen::Index(i)) -= values[std::size_t(s.pattern.diagonal(s.last[i]))];
  }
  return change(held);
}

bool TrailingFactor::change(std::span<const char> held) {
  Storage& s = *storage_;
  s.free.clear();
  for (std::size_t i = 0; i < s.last.size(); ++i) {
    if (held[std::size_t(s.last[i])] == 0) s.free.push_back(Eigen::Index(i));
  }
  const Eigen::MatrixXd part = s.schur(s.free, s.free);
  s.dense.compute(part);
  return s.dense.info() == Eigen::Success;
}

void TrailingFactor::solve(std::span<const double> b, std::span<double> x) {
  Storage& s = *storage_;
  s.right.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) s.right[i] = s.outside[i] != 0 ? 0.0 : b[i];
  auto y = s.CholmodFactor::solve(CHOLMOD_P, s.right);
  s.right.assign(y.begin(), y.end());
  y = s.CholmodFactor::solve(CHOLMOD_L, s.right);
  Eigen::Map<Eigen::VectorXd> tail(y.data() + s.first, Eigen::Index(s.last.size()));
  const Eigen::VectorXd load = s.lower * tail;
  const Eigen::VectorXd moved = s.dense.solve(load(s.free));
  Eigen::VectorXd all = Eigen::VectorXd::Zero(tail.size());
  all(s.free) = moved;
  for (std::size_t i = 0; i < s.first; ++i) y[i] /= s.diagonal[i];
  tail = s.lower.transpose() * all;
  s.right.assign(y.begin(), y.end());
  y = s.CholmodFactor::solve(CHOLMOD_Lt, s.right);
  s.right.assign(y.begin(), y.end());
  y = s.CholmodFactor::solve(CHOLMOD_Pt, s.right);
  std::copy(y.begin(), y.end(), x.begin());
}

}  // namespace dccast::linalg
