#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

#include "core/base/tensors.hpp"
#include "core/mechanics/mechanics_forms.hpp"
#include "core/mesh/mesh.hpp"

namespace dccast::mechanics {

/// The local frames of some nodes of a mesh, indexed by element: an element without such a node
/// costs one comparison.
///
/// Units: displacements, forces and matrices in any unit.
template <int Dim>
class NodeFrames {
public:
  using Frame = NodalFrame<Dim>;
  using Vector = typename Frame::Vector;

  /// Replaces all frames. @param frames  at most one for a node
  void set(const mesh::Mesh<Dim>& mesh, std::span<const Frame> frames) {
    frame_.assign(frames.begin(), frames.end());
    of_node_.clear();
    has_frame_.clear();
    if (frame_.empty()) return;
    of_node_.assign(std::size_t(mesh.nodes()), none);
    for (std::size_t f = 0; f < frame_.size(); ++f) {
      of_node_[std::size_t(frame_[f].node)] = static_cast<int>(f);
    }
    has_frame_.assign(std::size_t(mesh.elements()), 0);
    for (std::size_t i = 0; i < mesh.element_node.size(); ++i) {
      if (frame_of(mesh.element_node[i]) == nullptr) continue;
      has_frame_[i / std::size_t(mesh.nodes_per_element)] = 1;
    }
  }

  /// Whether a node of the element has a frame.
  bool has_frame(std::size_t element) const {
    return !has_frame_.empty() && has_frame_[element] != 0;
  }

  /// Transforms nodal vectors of an element from frames to coordinate axes; others stay.
  /// @param node  (Nodes) numbers of its nodes
  template <std::size_t Nodes>
  void to_coordinates(const int* node, std::array<Vector, Nodes>& v) const {
    for (std::size_t i = 0; i < Nodes; ++i) {
      if (const Frame* frame = frame_of(node[i])) v[i] = frame->to_coordinates(v[i]);
    }
  }
  /// The inverse of to_coordinates().
  template <std::size_t Nodes>
  void to_frames(const int* node, std::array<Vector, Nodes>& v) const {
    for (std::size_t i = 0; i < Nodes; ++i) {
      if (const Frame* frame = frame_of(node[i])) v[i] = frame->to_frame(v[i]);
    }
  }

  /// The same for an element matrix, given by its lower triangle, row by row.
  template <std::size_t Nodes>
  void to_frames(const int* node, std::array<double, Nodes * Dim * Nodes * Dim>& k) const {
    constexpr std::size_t n = Nodes * Dim;
    for (std::size_t r = 0; r < n; ++r) {
      // A matrix is transformed from both sides: T^T K T, row by row and column by column.
      for (std::size_t s = r + 1; s < n; ++s) k[r * n + s] = k[s * n + r];
    }
    const auto turn = [&](std::size_t first, std::size_t stride, const Frame& frame) {
      Vector v;
      for (std::size_t a = 0; a < v.size(); ++a) v[a] = k[first + a * stride];
      v = frame.to_frame(v);
      for (std::size_t a = 0; a < v.size(); ++a) k[first + a * stride] = v[a];
    };
    for (std::size_t i = 0; i < Nodes; ++i) {
      const Frame* frame = frame_of(node[i]);
      if (frame == nullptr) continue;
      for (std::size_t s = 0; s < n; ++s) turn(i * Dim * n + s, n, *frame);
      for (std::size_t r = 0; r < n; ++r) turn(r * n + i * Dim, 1, *frame);
    }
  }

  /// Adds a force along the coordinate axes to the force at a node.
  void add(std::span<double> force, int node, Vector v) const {
    if (const Frame* frame = frame_of(node)) v = frame->to_frame(v);
    for (std::size_t a = 0; a < v.size(); ++a) force[std::size_t(node) * Dim + a] += v[a];
  }
  /// Subtracts a force `by` along the last coordinate axis from the force at a node.
  void lower(std::span<double> force, int node, double by) const {
    double* f = &force[std::size_t(node) * Dim];
    if (const Frame* frame = frame_of(node)) {
      for (std::size_t k = 0; k < std::size_t(Dim); ++k) f[k] -= frame->axis[k][Dim - 1] * by;
    } else {
      f[Dim - 1] -= by;
    }
  }

private:
  /// Index of a node without a frame.
  static constexpr int none = -1;

  /// Frame of a node, or null.
  const Frame* frame_of(int node) const {
    if (of_node_.empty() || of_node_[std::size_t(node)] == none) return nullptr;
    return &frame_[std::size_t(of_node_[std::size_t(node)])];
  }

  std::vector<Frame> frame_;
  std::vector<int> of_node_;     ///< (node) index of its frame; empty without frames
  std::vector<char> has_frame_;  ///< (element) not zero if a node has a frame; empty without frames
};

/// Rotations of the element axes (corotational kinematics). An element works with the motion of its
/// nodes without the rotation R of its axes, R^T x - X, which is as small as its strain; its nodal
/// forces are rotated back with R (Felippa and Haugen 2005, without the spin of the axes within a
/// step). An element without a rotation costs one comparison.
///
/// Units: displacements [m]; forces and element matrices in any unit.
template <int Dim>
class ElementRotations {
public:
  using Vector = std::array<double, Dim>;
  using Matrix = std::array<Vector, Dim>;  ///< by row

  void clear() { rotation_.clear(); }
  /// No element has turned. @param elements  of the mesh
  void reset(std::size_t elements) { rotation_.assign(elements, identity()); }
  void set(std::size_t element, const Matrix& rotation) { rotation_[element] = rotation; }
  /// Whether the axes of an element have turned. The identity counts as no rotation.
  bool has_rotation(std::size_t element) const {
    return !rotation_.empty() && rotation_[element] != identity();
  }

  /// Transforms the nodal displacements of an element to its rotated axes. The displacement of the
  /// first node is subtracted from all: a translation causes no strain.
  template <std::size_t Nodes>
  void into_element(std::size_t element, const mesh::Mesh<Dim>& mesh,
                    std::array<Vector, Nodes>& displacement) const {
    const Matrix& r = rotation_[element];
    const int* node = mesh.nodes_of(static_cast<int>(element));
    const double* origin = mesh.point(node[0]);
    const Vector carried = displacement[0];
    for (std::size_t i = 0; i < Nodes; ++i) {
      const double* at = mesh.point(node[i]);
      Vector before, after;
      for (std::size_t a = 0; a < dim; ++a) {
        before[a] = at[a] - origin[a];
        after[a] = before[a] + displacement[i][a] - carried[a];
      }
      for (std::size_t a = 0; a < dim; ++a) {
        double seen = 0.0;
        for (std::size_t b = 0; b < dim; ++b) seen += r[b][a] * after[b];
        displacement[i][a] = seen - before[a];
      }
    }
  }

  /// Transforms nodal forces from the element's axes to the coordinate axes.
  template <std::size_t Nodes>
  void out_of_element(std::size_t element, std::array<Vector, Nodes>& force) const {
    for (Vector& f : force) f = product(rotation_[element], f);
  }

  /// The same for an element matrix, given by its lower triangle, row by row.
  template <std::size_t Nodes>
  void out_of_element(std::size_t element, std::array<double, Nodes * Dim * Nodes * Dim>& k) const {
    constexpr std::size_t n = Nodes * dim;
    const Matrix& r = rotation_[element];
    for (std::size_t i = 0; i < Nodes; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        Matrix block;
        for (std::size_t a = 0; a < dim; ++a) {
          for (std::size_t b = 0; b < dim; ++b) {
            const std::size_t row = i * dim + a, column = j * dim + b;
            block[a][b] = row >= column ? k[row * n + column] : k[column * n + row];
          }
        }
        block = turned(r, block);
        for (std::size_t a = 0; a < dim; ++a) {
          for (std::size_t b = 0; b < dim; ++b) k[(i * dim + a) * n + j * dim + b] = block[a][b];
        }
      }
    }
  }

private:
  static constexpr std::size_t dim = Dim;

  static constexpr Matrix identity() {
    Matrix one{};
    for (std::size_t a = 0; a < dim; ++a) one[a][a] = 1.0;
    return one;
  }
  static Vector product(const Matrix& r, const Vector& v) {
    Vector result{};
    for (std::size_t a = 0; a < dim; ++a) {
      for (std::size_t b = 0; b < dim; ++b) result[a] += r[a][b] * v[b];
    }
    return result;
  }
  /// R block R^T.
  static Matrix turned(const Matrix& r, const Matrix& block) {
    Matrix half{}, whole{};  // half: block R^T
    for (std::size_t a = 0; a < dim; ++a) {
      for (std::size_t b = 0; b < dim; ++b) {
        for (std::size_t c = 0; c < dim; ++c) half[a][b] += block[a][c] * r[b][c];
      }
    }
    for (std::size_t a = 0; a < dim; ++a) {
      for (std::size_t b = 0; b < dim; ++b) {
        for (std::size_t c = 0; c < dim; ++c) whole[a][b] += r[a][c] * half[c][b];
      }
    }
    return whole;
  }

  std::vector<Matrix> rotation_;  ///< (element); empty where none has turned
};

/// Rotation of the polar decomposition of I + g.
/// @param g  gradient of a displacement, row by component [1]
inline std::array<std::array<double, 2>, 2> rotation_of(std::array<std::array<double, 2>, 2> g) {
  const double angle = std::atan2(g[1][0] - g[0][1], 2.0 + g[0][0] + g[1][1]);
  const double c = std::cos(angle), s = std::sin(angle);
  return {{{c, -s}, {s, c}}};
}
inline Matrix3 rotation_of(Matrix3 g) {
  for (std::size_t a = 0; a < 3; ++a) g[a][a] += 1.0;
  return polar_rotation(g);
}

}  // namespace dccast::mechanics
