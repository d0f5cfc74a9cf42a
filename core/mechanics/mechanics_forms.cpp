#include "core/mechanics/mechanics_forms.hpp"

#include "core/fem/with_element.hpp"
#include "core/mechanics/forms_of.hpp"

namespace dccast::mechanics {

std::unique_ptr<MechanicsForms<2>> make_mechanics_forms(mesh::ElementKind element,
                                                        mesh::SectionKind section) {
  return fem::with_element(element, section,
                           []<class Element>() -> std::unique_ptr<MechanicsForms<2>> {
                             return std::make_unique<FormsOf<Element>>();
                           });
}

}  // namespace dccast::mechanics
