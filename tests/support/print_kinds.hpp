#pragma once

#include <ostream>

#include "core/mesh/section_spec.hpp"

// Names of elements and sections for GoogleTest, for tests that run for several of them.
namespace dccast::mesh {

inline void PrintTo(ElementKind element, std::ostream* out) {
  constexpr const char* names[] = {"p1", "q1", "q1_bending"};
  *out << names[static_cast<int>(element)];
}

inline void PrintTo(SectionKind kind, std::ostream* out) {
  *out << name_of(kind);
}

}  // namespace dccast::mesh
