#pragma once

#include <vector>

#include "core/results/frame.hpp"

namespace dccast::results {

/// A field of a frame that is derived from other fields and stored for visualisation programs.
struct DerivedField {
  const char* name;  ///< dataset in the frame's group
  const char* unit;
  const char* meaning;
  bool on_nodes;               ///< else on elements
  int components = 1;          ///< per node or element
  std::vector<double> values;  ///< [`unit`]
};

/// The derived fields that the fields of a frame permit: the displacement with three components if
/// it has two, the solid fraction, invariants of stress and viscoplastic strain, and contact
/// pressure and gap as fields on all nodes.
std::vector<DerivedField> derived_fields(const Frame& frame);

}  // namespace dccast::results
