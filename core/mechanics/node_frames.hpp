#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/mechanics/mechanics_forms.hpp"

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

  template <std::size_t Nodes>
  void to_coordinates(const int* node, std::array<Vector, Nodes>& v) const {
    for (std::size_t i = 0; i < Nodes; ++i) {
      if (const Frame* frame = frame_of(node[i])) v[i] = frame->to_coordinates(v[i]);
    }
  }
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
  static constexpr int none = -1;

  const Frame* frame_of(int node) const {
    if (of_node_.empty() || of_node_[std::size_t(node)] == none) return nullptr;
    return &frame_[std::size_t(of_node_[std::size_t(node)])];
  }

  std::vector<Frame> frame_;
  std::vector<int> of_node_;     ///< (node) index of its frame; empty without frames
  std::vector<char> has_frame_;  ///< (element) not zero if a node has a frame; empty without frames
};

}  // namespace dccast::mechanics
