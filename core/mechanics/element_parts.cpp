#include "core/mechanics/element_parts.hpp"

#include <algorithm>

namespace dccast::mechanics {

namespace {
/// Twice as many parts per colour as two threads need, so that others can take over from a delayed
/// thread.
constexpr std::size_t most_parts = 16;
constexpr std::size_t least_parts = 4;  // with fewer there is nothing to divide
}  // namespace

template <int Dim>
ElementParts ElementParts::of(const mesh::Mesh<Dim>& mesh) {
  ElementParts whole(std::size_t(mesh.elements()));
  const std::size_t blocks = whole.first_.back();
  for (std::size_t parts = most_parts; parts >= least_parts; parts /= 2) {
    if (parts > blocks) continue;
    ElementParts divided;
    divided.first_.clear();
    for (std::size_t p = 0; p <= parts; ++p) divided.first_.push_back(blocks * p / parts);
    if (divided.divide(mesh)) return divided;
  }
  return whole;
}

/// Whether parts of one colour have no node in common.
template <int Dim>
bool ElementParts::divide(const mesh::Mesh<Dim>& mesh) const {
  std::vector<int> owner[2];  // (colour, node) part; -1 for none
  for (auto& of_colour : owner) of_colour.assign(std::size_t(mesh.nodes()), -1);
  for (std::size_t part = 0; part < parts(); ++part) {
    std::vector<int>& of_colour = owner[part % 2];
    const std::size_t end =
        std::min(first_[part + 1] * elements_in_block, std::size_t(mesh.elements()));
    for (std::size_t e = first_[part] * elements_in_block; e < end; ++e) {
      const int* node = mesh.nodes_of(static_cast<int>(e));
      for (int i = 0; i < mesh.nodes_per_element; ++i) {
        int& its = of_colour[std::size_t(node[i])];
        if (its != -1 && its != static_cast<int>(part)) return false;
        its = static_cast<int>(part);
      }
    }
  }
  return true;
}

template ElementParts ElementParts::of(const mesh::Mesh<2>&);
template ElementParts ElementParts::of(const mesh::Mesh<3>&);

}  // namespace dccast::mechanics
