#include "core/linalg/cholmod_solver.hpp"

#include <cholmod.h>
#include <omp.h>

#include <cstring>
#include <new>
#include <stdexcept>
#include <vector>

extern "C" void openblas_set_num_threads(int);

namespace dccast::linalg {

namespace {

/// Measured: the simplicial code is faster at 1,500 unknowns and 3 times slower at 30,000.
constexpr int simplicial_up_to = 6000;

/// Limits BLAS and CHOLMOD to the calling thread. CHOLMOD's supernodal code explicitly requests
/// four threads, regardless of OMP_NUM_THREADS; with zero active levels of parallel regions it gets
/// one.
void stay_on_this_thread() {
  openblas_set_num_threads(1);
  omp_set_max_active_levels(0);
}

/// LDL' succeeds on an indefinite matrix, and the supernodal code on one with NaN; the diagonal of
/// the factor reveals both.
bool positive_diagonal(const cholmod_factor& factor) {
  const auto* value = static_cast<const double*>(factor.x);
  if (factor.is_super == 0) {
    const auto* start = static_cast<const int*>(factor.p);
    for (std::size_t c = 0; c < factor.n; ++c) {
      if (!(value[start[c]] > 0.0)) return false;
    }
    return true;
  }

  // Supernodal: dense blocks of columns.
  const auto* first_column = static_cast<const int*>(factor.super);
  const auto* rows = static_cast<const int*>(factor.pi);
  const auto* block = static_cast<const int*>(factor.px);
  for (std::size_t s = 0; s < factor.nsuper; ++s) {
    const int columns = first_column[s + 1] - first_column[s], height = rows[s + 1] - rows[s];
    for (int c = 0; c < columns; ++c) {
      if (!(value[block[s] + c * height + c] > 0.0)) return false;
    }
  }
  return true;
}

/// A symmetric matrix by the pattern of its lower triangle. CHOLMOD takes pointers to mutable data
/// but does not write to an input matrix.
cholmod_sparse pattern_matrix(int size, const std::vector<int>& column_start,
                              const std::vector<int>& row) {
  cholmod_sparse matrix{};
  matrix.nrow = matrix.ncol = std::size_t(size);
  matrix.nzmax = row.size();
  matrix.p = const_cast<int*>(column_start.data());
  matrix.i = const_cast<int*>(row.data());
  matrix.stype = -1;
  matrix.itype = CHOLMOD_INT;
  matrix.xtype = CHOLMOD_PATTERN;
  matrix.dtype = CHOLMOD_DOUBLE;
  matrix.sorted = matrix.packed = 1;
  return matrix;
}

/// Order of elimination by nested dissection (METIS) of the graph of nodes; the unknowns of a node
/// follow each other. That graph has a ninth of the edges, and the fill is the same.
/// @return (position) unknown; empty if METIS fails
std::vector<int> dissect_nodes(const SparsityPattern& pattern, cholmod_common& common) {
  const int per_node = pattern.unknowns_per_node(), nodes = pattern.unknowns() / per_node;
  // Compressed graph of the nodes: a node takes the neighbours of its first unknown.
  std::vector<int> start{0}, neighbour;
  for (int node = 0; node < nodes; ++node) {
    const int column = node * per_node;
    for (int k = pattern.diagonal(column); k < pattern.diagonal(column + 1); k += per_node) {
      neighbour.push_back(pattern.row()[std::size_t(k)] / per_node);
    }
    start.push_back(static_cast<int>(neighbour.size()));
  }

  cholmod_sparse graph = pattern_matrix(nodes, start, neighbour);
  std::vector<int> node_order(std::size_t(nodes), 0), order;
  if (cholmod_metis(&graph, nullptr, 0, 1, node_order.data(), &common) == 0) return {};

  for (const int node : node_order) {
    for (int d = 0; d < per_node; ++d) order.push_back(node * per_node + d);
  }
  return order;
}

}  // namespace

struct CholmodSolver::Storage {
  cholmod_common common{};
  cholmod_sparse matrix{};  // a view of the caller's arrays
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;
  cholmod_dense* work_y = nullptr;  // workspace of cholmod_solve2()
  cholmod_dense* work_e = nullptr;

  Storage() {
    cholmod_start(&common);
    common.print = 0;
    common.error_handler = nullptr;
  }
  ~Storage() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&work_y, &common);
    cholmod_free_dense(&work_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
};

CholmodSolver::CholmodSolver() : storage_(std::make_unique<Storage>()) {}
CholmodSolver::~CholmodSolver() = default;
CholmodSolver::CholmodSolver(CholmodSolver&&) noexcept = default;
CholmodSolver& CholmodSolver::operator=(CholmodSolver&&) noexcept = default;

void CholmodSolver::analyze(const SparsityPattern& pattern, Geometry geometry) {
  Storage& s = *storage_;
  cholmod_free_factor(&s.factor, &s.common);
  s.matrix = pattern_matrix(pattern.unknowns(), pattern.column_start(), pattern.row());

  // Minimum degree unless nodes are dissected below.
  s.common.nmethods = 1;
  s.common.method[0].ordering = CHOLMOD_AMD;
  s.common.postorder = 1;

  // Small plane problems are faster column by column than by supernodes.
  const bool simplicial = geometry == Geometry::plane && pattern.unknowns() <= simplicial_up_to;
  s.common.supernodal = simplicial ? CHOLMOD_SIMPLICIAL : CHOLMOD_SUPERNODAL;
  s.common.final_ll = simplicial ? 0 : 1;

  std::vector<int> order;
  if (geometry == Geometry::solid) order = dissect_nodes(pattern, s.common);
  if (!order.empty()) s.common.method[0].ordering = CHOLMOD_GIVEN;
  s.factor =
      cholmod_analyze_p(&s.matrix, order.empty() ? nullptr : order.data(), nullptr, 0, &s.common);
  if (s.factor == nullptr) throw std::bad_alloc();
}

bool CholmodSolver::factorize(std::span<const double> values) {
  stay_on_this_thread();
  Storage& s = *storage_;
  s.matrix.xtype = CHOLMOD_REAL;
  s.matrix.x = const_cast<double*>(values.data());

  const int ok = cholmod_factorize(&s.matrix, s.factor, &s.common);
  if (s.common.status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  if (ok == 0 || s.common.status == CHOLMOD_NOT_POSDEF || s.factor->minor < s.factor->n) {
    return false;
  }
  return positive_diagonal(*s.factor);
}

void CholmodSolver::solve(std::span<const double> b, std::span<double> x) {
  stay_on_this_thread();
  Storage& s = *storage_;
  // A view of the caller's right-hand side.
  cholmod_dense right{};
  right.nrow = right.nzmax = right.d = b.size();
  right.ncol = 1;
  right.x = const_cast<double*>(b.data());
  right.xtype = CHOLMOD_REAL;
  right.dtype = CHOLMOD_DOUBLE;

  const int ok = cholmod_solve2(CHOLMOD_A, s.factor, &right, nullptr, &s.solution, nullptr,
                                &s.work_y, &s.work_e, &s.common);
  if (ok == 0) throw std::runtime_error("CHOLMOD could not solve with its factor");
  std::memcpy(x.data(), s.solution->x, x.size() * sizeof(double));
}

double CholmodSolver::factor_entries() const {
  return storage_->common.lnz;
}

std::size_t CholmodSolver::memory_bytes() const {
  const cholmod_factor* factor = storage_->factor;
  if (factor == nullptr) return 0;
  const std::size_t numbers = factor->is_super != 0 ? factor->xsize : factor->nzmax;
  const std::size_t places = factor->is_super != 0 ? factor->ssize : factor->nzmax;
  return numbers * sizeof(double) + places * sizeof(int);
}

}  // namespace dccast::linalg
