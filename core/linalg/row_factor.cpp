#include <algorithm>
#include <new>

#include "core/linalg/cholmod_factor.hpp"
#include "core/linalg/contact_factor.hpp"

namespace dccast::linalg {

struct RowFactor::Storage : CholmodFactor {
  explicit Storage(const SparsityPattern& p) : CholmodFactor(p), pattern(p), unit(matrix.nrow) {
    common.method[0].ordering = CHOLMOD_AMD;
    common.postorder = 1;
    choose_kind();
    factor = cholmod_analyze(&matrix, &common);
    if (factor == nullptr) throw std::bad_alloc();
    place.resize(factor->n);
    for (std::size_t i = 0; i < factor->n; ++i) {
      place[std::size_t(static_cast<const int*>(factor->Perm)[i])] = static_cast<int>(i);
    }
  }

  void to_rows() {
    if (rows) return;
    cholmod_change_factor(CHOLMOD_REAL, 0, 0, 1, 1, factor, &common);
    rows = true;
  }

  /// Column of an unknown that becomes free, on the unknowns that are, in the factor's order.
  bool add(int unknown) {
    std::fill(unit.begin(), unit.end(), 0.0);
    unit[std::size_t(unknown)] = 1.0;
    column.resize(unit.size());
    multiply(pattern, values, unit, column);
    entries.clear();
    for (std::size_t i = 0; i < column.size(); ++i) {
      const bool free = held[i] == 0 || static_cast<int>(i) == unknown;
      if (column[i] != 0.0 && free) entries.push_back({place[i], column[i]});
    }
    std::sort(entries.begin(), entries.end());
    std::vector<int> row;
    std::vector<double> value;
    for (const auto& [at, entry] : entries) row.push_back(at), value.push_back(entry);
    int start[2] = {0, static_cast<int>(row.size())};
    cholmod_sparse sparse{};
    sparse.nrow = factor->n;
    sparse.ncol = 1;
    sparse.nzmax = row.size();
    sparse.p = start;
    sparse.i = row.data();
    sparse.x = value.data();
    sparse.itype = CHOLMOD_INT;
    sparse.xtype = CHOLMOD_REAL;
    sparse.dtype = CHOLMOD_DOUBLE;
    sparse.sorted = sparse.packed = 1;
    return cholmod_rowadd(std::size_t(place[std::size_t(unknown)]), &sparse, factor, &common) != 0;
  }
  bool drop(int unknown) {
    return cholmod_rowdel(std::size_t(place[std::size_t(unknown)]), nullptr, factor, &common) != 0;
  }

  bool positive() const {
    const auto* start = static_cast<const int*>(factor->p);
    const auto* value = static_cast<const double*>(factor->x);
    for (std::size_t c = 0; c < factor->n; ++c) {
      if (!(value[start[c]] > 0.0)) return false;
    }
    return true;
  }

  const SparsityPattern& pattern;
  std::span<const double> values;
  std::vector<int> place;  ///< (unknown) in the factor's order
  std::vector<char> held;
  bool rows = false;  ///< the factor takes rows
  std::vector<double> unit, column, right;
  std::vector<std::pair<int, double>> entries;
};

RowFactor::RowFactor(const SparsityPattern& pattern)
    : storage_(std::make_unique<Storage>(pattern)) {}
RowFactor::~RowFactor() = default;

bool RowFactor::factorize(std::span<const double> values, std::span<const char> held) {
  Storage& s = *storage_;
  if (s.rows) {  // what rows were added and deleted from has lost the analysis
    auto fresh = std::make_unique<Storage>(s.pattern);
    storage_ = std::move(fresh);
    return factorize(values, held);
  }
  s.values = values;
  s.held.assign(held.begin(), held.end());
  empty_held(s.pattern, values, held, s.masked);
  return s.CholmodFactor::factorize();
}

bool RowFactor::change(std::span<const char> held) {
  Storage& s = *storage_;
  s.to_rows();
  for (std::size_t i = 0; i < held.size(); ++i) {
    if (held[i] == s.held[i]) continue;
    if (held[i] == 0) s.drop(static_cast<int>(i));  // its row of numbers that are zero
    if (!(held[i] != 0 ? s.drop(static_cast<int>(i)) : s.add(static_cast<int>(i)))) return false;
    s.held[i] = held[i];
  }
  return s.positive();
}

void RowFactor::solve(std::span<const double> b, std::span<double> x) {
  Storage& s = *storage_;
  s.right.resize(b.size());
  for (std::size_t i = 0; i < b.size(); ++i) s.right[i] = s.held[i] != 0 ? 0.0 : b[i];
  const auto y = s.CholmodFactor::solve(CHOLMOD_A, s.right);
  std::copy(y.begin(), y.end(), x.begin());
}

}  // namespace dccast::linalg
