#pragma once

#include <vector>

#include "core/results/frame.hpp"

namespace dccast::results {

/// A field of a frame that follows from others and is stored for programs that show results.
struct DerivedField {
  const char* name;  ///< dataset in the frame's group
  const char* unit;
  const char* meaning;
  bool on_nodes;               ///< else on elements
  int components = 1;          ///< of a value
  std::vector<double> values;  ///< in `unit`
};

/// Those that the frame's own fields permit: the displacement with three components where it has
/// two, the solid fraction, the von Mises stress and the contact pressure as a field on all nodes.
std::vector<DerivedField> derived_fields(const Frame& frame);

}  // namespace dccast::results
