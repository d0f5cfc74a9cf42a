#pragma once

#include <stdexcept>
#include <utility>

#include "core/fem/element.hpp"
#include "core/mesh/section_spec.hpp"

namespace dccast::fem {

/// Calls `use.operator()<Element>()` with the element type of a section. This is the only place
/// where the element of a case is turned into a type.
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

/// The same for the elements of a solid: tetrahedra or hexahedra.
template <class Use>
decltype(auto) with_solid_element(mesh::ElementKind element, Use&& use) {
  switch (element) {
    case mesh::ElementKind::p1:
      return use.template operator()<P1Tetrahedron>();
    case mesh::ElementKind::q1:
      return use.template operator()<Q1Hexahedron>();
    case mesh::ElementKind::q1_bending:
      return use.template operator()<BendingHexahedron>();
  }
  throw std::logic_error("with_solid_element: an element without a type");
}

}  // namespace dccast::fem
