#pragma once

#include <stdexcept>
#include <utility>

#include "core/fem/element.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::fem {

/// Calls `use.operator()<Element>()` with the element of a section. Who needs the element as a type
/// comes through here.
template <class Use>
decltype(auto) with_element(mesh::ElementKind element, mesh::SectionKind section, Use&& use) {
  const bool round = section == mesh::SectionKind::axisymmetric;
  switch (element) {
    case mesh::ElementKind::p1:
      return round ? use.template operator()<AxisymmetricP1>()
                   : use.template operator()<P1Triangle>();
    case mesh::ElementKind::q1:
      return round ? use.template operator()<AxisymmetricQ1>()
                   : use.template operator()<Q1Quadrilateral>();
    case mesh::ElementKind::q1_bending:
      return round ? use.template operator()<AxisymmetricBending>()
                   : use.template operator()<BendingQuadrilateral>();
  }
  throw std::logic_error("with_element: an element without a type");
}

/// The same with the elements of a solid: of tetrahedra or hexahedra.
template <class Use>
decltype(auto) with_solid_element(mesh::ElementKind element, Use&& use) {
  switch (element) {
    case mesh::ElementKind::p1: return use.template operator()<P1Tetrahedron>();
    case mesh::ElementKind::q1: return use.template operator()<Q1Hexahedron>();
    case mesh::ElementKind::q1_bending: return use.template operator()<BendingHexahedron>();
  }
  throw std::logic_error("with_solid_element: an element without a type");
}

}  // namespace dccast::fem
