// Each enumerator of the schema has one of the core: an algorithm that is forgotten must not run as
// another one.
#include "server/translate/enumerations.hpp"

#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

namespace dccast::translate {
namespace {

/// The counterparts of all enumerators but UNSPECIFIED, which is 0.
template <class From>
auto counterparts(const google::protobuf::EnumDescriptor& enumeration) {
  std::set<decltype(to_core(From()))> found;
  for (int i = 0; i < enumeration.value_count(); ++i)
    if (const int number = enumeration.value(i)->number(); number != 0)
      found.insert(to_core(static_cast<From>(number)));
  return found;
}

template <class From>
void expect_a_counterpart_each(const google::protobuf::EnumDescriptor& enumeration) {
  EXPECT_EQ(static_cast<int>(counterparts<From>(enumeration).size()), enumeration.value_count() - 1)
      << enumeration.full_name();
}

TEST(Enumerations, EachEnumeratorHasACounterpartOfItsOwn) {
  expect_a_counterpart_each<v1::Abscissa>(*v1::Abscissa_descriptor());
  expect_a_counterpart_each<v1::Section::Kind>(*v1::Section::Kind_descriptor());
  expect_a_counterpart_each<v1::ElementKind>(*v1::ElementKind_descriptor());
  expect_a_counterpart_each<v1::Cooling::Top>(*v1::Cooling::Top_descriptor());
  expect_a_counterpart_each<v1::Mechanics::Algorithm>(*v1::Mechanics::Algorithm_descriptor());
  expect_a_counterpart_each<v1::Mechanics::Liquid>(*v1::Mechanics::Liquid_descriptor());
  expect_a_counterpart_each<v1::Mechanics::Hold>(*v1::Mechanics::Hold_descriptor());
  expect_a_counterpart_each<v1::Mechanics::Kinematics>(*v1::Mechanics::Kinematics_descriptor());
  expect_a_counterpart_each<v1::Validity::WhenLost>(*v1::Validity::WhenLost_descriptor());
  expect_a_counterpart_each<v1::OtherVersion>(*v1::OtherVersion_descriptor());
  expect_a_counterpart_each<v1::SideZone::Face>(*v1::SideZone::Face_descriptor());
}

TEST(Enumerations, UnspecifiedIsTheDefaultOfTheSchema) {
  EXPECT_EQ(to_core(v1::Mechanics::ALGORITHM_UNSPECIFIED), mechanics::Options().algorithm);
  EXPECT_EQ(to_core(v1::Mechanics::LIQUID_UNSPECIFIED), mechanics::Options().liquid);
  EXPECT_EQ(to_core(v1::Mechanics::HOLD_UNSPECIFIED), mechanics::Options().confinement_by);
  EXPECT_EQ(to_core(v1::Validity::WHEN_LOST_UNSPECIFIED), casting::Validity().when_lost);
  EXPECT_EQ(to_core(v1::ELEMENT_KIND_UNSPECIFIED), mesh::ElementKind::q1_bending);
  EXPECT_EQ(to_core(v1::Section::KIND_UNSPECIFIED), mesh::SectionSpec().kind);
  EXPECT_EQ(to_core(v1::Cooling::TOP_UNSPECIFIED), thermal::CoolingSpec().top);
}

TEST(Enumerations, ANumberOutsideOfTheSchemaIsNoAlgorithm) {
  EXPECT_THROW(to_core(static_cast<v1::Mechanics::Algorithm>(7)), std::logic_error);
  EXPECT_THROW(is_steel(static_cast<v1::BottomBlock::Material>(7)), std::logic_error);
}

}  // namespace
}  // namespace dccast::translate
