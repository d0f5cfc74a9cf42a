#include "core/thermal/heat_forms.hpp"

#include "core/fem/with_element.hpp"
#include "core/thermal/heat_forms_of.hpp"
#include "core/thermal/row_merging.hpp"

namespace dccast::thermal {
namespace {

/// For conduction the bending elements are treated as the plain bilinear and trilinear ones.
template <class Element>
struct Conducting {
  using Type = Element;
};
template <>
struct Conducting<fem::BendingQuadrilateral> {
  using Type = fem::Q1Quadrilateral;
};
template <>
struct Conducting<fem::AxisymmetricBending> {
  using Type = fem::AxisymmetricQ1;
};
template <>
struct Conducting<fem::BendingHexahedron> {
  using Type = fem::Q1Hexahedron;
};

}  // namespace

void HeatForms::follow_merging(const mesh::MergedRows& merged, std::vector<double>& enthalpy) {
  const std::vector<double> before = volume_;
  update();
  merge_enthalpy(merged, before, volume_, enthalpy);
}

std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<2>& mesh, mesh::SectionKind kind) {
  const auto element = mesh.nodes_per_element == 3 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;
  return fem::with_element(element, kind, [&]<class Element>() -> std::unique_ptr<HeatForms> {
    return std::make_unique<HeatFormsOf<typename Conducting<Element>::Type>>(mesh);
  });
}

std::unique_ptr<HeatForms> make_heat_forms(const mesh::Mesh<3>& mesh, mesh::SectionKind) {
  const auto element = mesh.nodes_per_element == 4 ? mesh::ElementKind::p1 : mesh::ElementKind::q1;
  return fem::with_solid_element(element, [&]<class Element>() -> std::unique_ptr<HeatForms> {
    return std::make_unique<HeatFormsOf<typename Conducting<Element>::Type>>(mesh);
  });
}

}  // namespace dccast::thermal
