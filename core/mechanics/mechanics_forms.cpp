#include "core/mechanics/mechanics_forms.hpp"

#include "core/fem/element.hpp"
#include "core/mechanics/forms_of.hpp"

namespace dccast::mechanics {

std::unique_ptr<MechanicsForms<2>> make_mechanics_forms(mesh::ElementKind element,
                                                        mesh::SectionKind section) {
  return fem::with_element(element, section,
                           []<class Element>() -> std::unique_ptr<MechanicsForms<2>> {
                             return std::make_unique<FormsOf<Element>>();
                           });
}

std::unique_ptr<MechanicsForms<3>> make_solid_forms(mesh::ElementKind element) {
  return fem::with_solid_element(element,
                                 []<class Element>() -> std::unique_ptr<MechanicsForms<3>> {
                                   return std::make_unique<FormsOf<Element>>();
                                 });
}

}  // namespace dccast::mechanics
