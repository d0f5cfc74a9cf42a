#pragma once

#include <array>
#include <vector>

#include "core/linalg/sparsity_pattern.hpp"

namespace dccast::support {

/// Stiffness matrix of a quarter slab of equal trilinear hexahedra with 2 x 2 x 2 points, like the
/// matrices of the mechanics in 3D. Nodes are numbered row by row from the bottom, within a row
/// along x first; unknown = 3 node + direction.
class BrickMatrix {
public:
  /// @param plan  cells along x and y
  /// @param rows  of cells along z
  /// @param size  of a cell along x, y, z [m]
  BrickMatrix(std::array<int, 2> plan, int rows, std::array<double, 3> size = {0.03, 0.03, 0.01});

  int unknowns() const { return pattern.unknowns(); }
  int node(int i, int j, int k) const { return (k * (plan_[1] + 1) + j) * (plan_[0] + 1) + i; }
  int cells() const { return plan_[0] * plan_[1] * rows_; }
  const std::array<int, 2>& plan() const { return plan_; }
  int rows() const { return rows_; }
  /// (3 node) coordinates [m]
  std::vector<double> coordinates() const;

  /// Entries of the pattern, nothing held.
  /// @param modulus  Young's modulus of a cell [Pa], called with its place in x, y and z
  template <class Modulus>
  std::vector<double> stiffness(double poisson, const Modulus& modulus) const {
    std::vector<double> values(pattern.entries(), 0.0);
    const std::vector<double> unit = cell_stiffness(poisson);
    int e = 0;
    for (int k = 0; k < rows_; ++k) {
      for (int j = 0; j < plan_[1]; ++j) {
        for (int i = 0; i < plan_[0]; ++i) add(values, e++, unit, modulus(i, j, k));
      }
    }
    return values;
  }

  /// (unknown) not zero where held: the normal displacement on the planes x = 0 and y = 0, and the
  /// vertical one of the nodes of the bottom within `standing` cells of the centre.
  std::vector<char> supports(int standing) const;

  const std::vector<int>& cell_unknowns() const { return cell_unknown_; }

private:
  std::vector<double> cell_stiffness(double poisson) const;
  /// Adds the matrix of a cell: `unit`, that of E = 1, times its modulus.
  void add(std::vector<double>& values, int cell, const std::vector<double>& unit,
           double modulus) const;

  std::array<int, 2> plan_;
  int rows_;
  std::array<double, 3> size_;
  std::vector<int> cell_unknown_;  ///< (cell, 24)

public:
  linalg::SparsityPattern pattern;
};

/// Sets rows and columns of the held unknowns to zero, except for their diagonal.
void decouple(const linalg::SparsityPattern& pattern, const std::vector<char>& held,
              std::vector<double>& values);

}  // namespace dccast::support
