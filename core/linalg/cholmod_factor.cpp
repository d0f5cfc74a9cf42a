#include "core/linalg/cholmod_factor.hpp"

#include <new>
#include <stdexcept>

extern "C" void openblas_set_num_threads(int);

namespace dccast::linalg {

namespace {
constexpr std::size_t simplicial_up_to = 6000;  // see CholmodSolver
}  // namespace

CholmodFactor::CholmodFactor(const SparsityPattern& pattern) {
  openblas_set_num_threads(1);
  cholmod_start(&common);
  common.print = 0;
  common.nmethods = 1;
  masked.assign(pattern.entries(), 0.0);
  matrix.nrow = matrix.ncol = std::size_t(pattern.unknowns());
  matrix.nzmax = pattern.entries();
  // CHOLMOD takes pointers to mutable data but does not write to an input matrix.
  matrix.p = const_cast<int*>(pattern.column_start().data());
  matrix.i = const_cast<int*>(pattern.row().data());
  matrix.x = masked.data();
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_REAL;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
}

CholmodFactor::~CholmodFactor() {
  cholmod_free_dense(&solution, &common);
  cholmod_free_dense(&work_y, &common);
  cholmod_free_dense(&work_e, &common);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
}

void CholmodFactor::choose_kind() {
  const bool simplicial = matrix.nrow <= simplicial_up_to;
  common.supernodal = simplicial ? CHOLMOD_SIMPLICIAL : CHOLMOD_SUPERNODAL;
  common.final_ll = simplicial ? 0 : 1;
}

bool CholmodFactor::factorize() {
  const int ok = cholmod_factorize(&matrix, factor, &common);
  if (common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return ok != 0 && common.status == CHOLMOD_OK && factor->minor == factor->n;
}

std::span<double> CholmodFactor::solve(int system, std::span<const double> b) {
  cholmod_dense right{};
  right.nrow = right.nzmax = right.d = b.size();
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;
  if (cholmod_solve2(system, factor, &right, nullptr, &solution, nullptr, &work_y, &work_e,
                     &common) == 0) {
    throw std::runtime_error("CHOLMOD could not solve with its factor");
  }
  return {static_cast<double*>(solution->x), b.size()};
}

void empty_held(const SparsityPattern& pattern, std::span<const double> values,
                std::span<const char> held, std::vector<double>& masked) {
  masked.assign(values.begin(), values.end());
  const auto& start = pattern.column_start();
  for (std::size_t c = 0; c + 1 < start.size(); ++c) {
    const std::size_t diagonal = std::size_t(start[c]);
    for (std::size_t k = diagonal + 1; k < std::size_t(start[c + 1]); ++k) {
      if (held[c] != 0 || held[std::size_t(pattern.row()[k])] != 0) masked[k] = 0.0;
    }
    // Its own diagonal keeps the scale of the neighbourhood, and with it the pivots' scale.
    if (held[c] != 0 && !(masked[diagonal] > 0.0)) masked[diagonal] = 1.0;
  }
}

}  // namespace dccast::linalg
