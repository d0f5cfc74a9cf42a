#include "server/translate/enumerations.hpp"

#include <fmt/core.h>

#include <stdexcept>
#include <string_view>

// Protobuf adds two enumerators to each enumeration, which no message holds: they give the type its
// range.
#define DCCAST_RANGE_OF(enumeration)                   \
  case v1::enumeration##_INT_MIN_SENTINEL_DO_NOT_USE_: \
  case v1::enumeration##_INT_MAX_SENTINEL_DO_NOT_USE_: \
    break

namespace dccast::translate {

namespace {

[[noreturn]] void refuse(std::string_view enumeration, int number) {
  throw std::logic_error(fmt::format("{} of the schema has no enumerator {}", enumeration, number));
}

}  // namespace

Abscissa to_core(v1::Abscissa from) {
  switch (from) {
    case v1::ABSCISSA_UNSPECIFIED:
      return Abscissa::none;
    case v1::TIME:
      return Abscissa::time;
    case v1::CAST_LENGTH:
      return Abscissa::cast_length;
    case v1::TEMPERATURE:
      return Abscissa::temperature;
    case v1::GAP:
      return Abscissa::gap;
    case v1::DISTANCE:
      return Abscissa::distance;
    case v1::LIQUID_FRACTION:
      return Abscissa::liquid_fraction;
      DCCAST_RANGE_OF(Abscissa);
  }
  refuse("Abscissa", from);
}

mesh::SectionKind to_core(v1::Section::Kind from) {
  switch (from) {
    case v1::Section::KIND_UNSPECIFIED:
    case v1::Section::PLANE_STRAIN:
      return mesh::SectionKind::plane_strain;
    case v1::Section::AXISYMMETRIC:
      return mesh::SectionKind::axisymmetric;
    case v1::Section::QUARTER_SLAB:
      return mesh::SectionKind::quarter_slab;
      DCCAST_RANGE_OF(Section_Kind_Section_Kind);
  }
  refuse("Section.Kind", from);
}

mesh::ElementKind to_core(v1::ElementKind from) {
  switch (from) {
    case v1::P1:
      return mesh::ElementKind::p1;
    case v1::Q1:
      return mesh::ElementKind::q1;
    case v1::ELEMENT_KIND_UNSPECIFIED:
    case v1::Q1_BENDING:
      return mesh::ElementKind::q1_bending;
      DCCAST_RANGE_OF(ElementKind);
  }
  refuse("ElementKind", from);
}

thermal::Top to_core(v1::Cooling::Top from) {
  switch (from) {
    case v1::Cooling::TOP_UNSPECIFIED:
    case v1::Cooling::POURING:
      return thermal::Top::pouring;
    case v1::Cooling::INSULATED:
      return thermal::Top::insulated;
    case v1::Cooling::HELD:
      return thermal::Top::held;
      DCCAST_RANGE_OF(Cooling_Top_Cooling_Top);
  }
  refuse("Cooling.Top", from);
}

mechanics::Algorithm to_core(v1::Mechanics::Algorithm from) {
  switch (from) {
    case v1::Mechanics::ALGORITHM_UNSPECIFIED:
    case v1::Mechanics::NEWTON:
      return mechanics::Algorithm::newton;
    case v1::Mechanics::VNBM:
      return mechanics::Algorithm::vnbm;
    case v1::Mechanics::SBM:
      return mechanics::Algorithm::sbm;
    case v1::Mechanics::NBM:
      return mechanics::Algorithm::nbm;
      DCCAST_RANGE_OF(Mechanics_Algorithm_Mechanics_Algorithm);
  }
  refuse("Mechanics.Algorithm", from);
}

mechanics::Liquid to_core(v1::Mechanics::Liquid from) {
  switch (from) {
    case v1::Mechanics::LIQUID_UNSPECIFIED:
    case v1::Mechanics::PRESSURE:
      return mechanics::Liquid::pressure;
    case v1::Mechanics::WEAK:
      return mechanics::Liquid::weak;
    case v1::Mechanics::SOLID:
      return mechanics::Liquid::solid;
      DCCAST_RANGE_OF(Mechanics_Liquid_Mechanics_Liquid);
  }
  refuse("Mechanics.Liquid", from);
}

mechanics::Confinement to_core(v1::Mechanics::Hold from) {
  switch (from) {
    case v1::Mechanics::HOLD_UNSPECIFIED:
    case v1::Mechanics::EXACT:
      return mechanics::Confinement::exact;
    case v1::Mechanics::PENALTY:
      return mechanics::Confinement::penalty;
      DCCAST_RANGE_OF(Mechanics_Hold_Mechanics_Hold);
  }
  refuse("Mechanics.Hold", from);
}

casting::WhenLost to_core(v1::Validity::WhenLost from) {
  switch (from) {
    case v1::Validity::WHEN_LOST_UNSPECIFIED:
    case v1::Validity::STOP:
      return casting::WhenLost::stop;
    case v1::Validity::CONTINUE:
      return casting::WhenLost::go_on;
      DCCAST_RANGE_OF(Validity_WhenLost_Validity_WhenLost);
  }
  refuse("Validity.WhenLost", from);
}

casting::OtherVersion to_core(v1::OtherVersion from) {
  switch (from) {
    case v1::OTHER_VERSION_UNSPECIFIED:
    case v1::BEGIN_ANEW:
      return casting::OtherVersion::begin_anew;
    case v1::PAUSE:
      return casting::OtherVersion::wait;
    case v1::FAIL:
      return casting::OtherVersion::fail;
      DCCAST_RANGE_OF(OtherVersion);
  }
  refuse("OtherVersion", from);
}

std::optional<thermal::Face> to_core(v1::SideZone::Face from) {
  switch (from) {
    case v1::SideZone::FACE_UNSPECIFIED:
    case v1::SideZone::EVERY:
      return std::nullopt;
    case v1::SideZone::WIDE:
      return thermal::Face::wide;
    case v1::SideZone::NARROW:
      return thermal::Face::narrow;
      DCCAST_RANGE_OF(SideZone_Face_SideZone_Face);
  }
  refuse("SideZone.Face", from);
}

std::optional<mechanics::Kinematics> to_core(v1::Mechanics::Kinematics from) {
  switch (from) {
    case v1::Mechanics::KINEMATICS_UNSPECIFIED:
      return std::nullopt;
    case v1::Mechanics::SMALL_STRAIN:
      return mechanics::Kinematics::small_strain;
    case v1::Mechanics::COROTATIONAL:
      return mechanics::Kinematics::corotational;
      DCCAST_RANGE_OF(Mechanics_Kinematics_Mechanics_Kinematics);
  }
  refuse("Mechanics.Kinematics", from);
}

bool is_fed(v1::Alloy::CellMass from) {
  switch (from) {
    case v1::Alloy::CELL_MASS_UNSPECIFIED:
    case v1::Alloy::MIXTURE:
      return false;
    case v1::Alloy::FED:
      return true;
      DCCAST_RANGE_OF(Alloy_CellMass_Alloy_CellMass);
  }
  refuse("Alloy.CellMass", from);
}

bool is_steel(v1::BottomBlock::Material from) {
  switch (from) {
    case v1::BottomBlock::MATERIAL_UNSPECIFIED:
    case v1::BottomBlock::ALUMINIUM:
      return false;
    case v1::BottomBlock::STEEL:
      return true;
      DCCAST_RANGE_OF(BottomBlock_Material_BottomBlock_Material);
  }
  refuse("BottomBlock.Material", from);
}

v1::RunEnd::Outcome to_proto(casting::RunEnd from) {
  switch (from) {
    case casting::RunEnd::succeeded:
      return v1::RunEnd::SUCCEEDED;
    case casting::RunEnd::failed:
      return v1::RunEnd::FAILED;
    case casting::RunEnd::stopped:
      return v1::RunEnd::STOPPED;
    case casting::RunEnd::cancelled:
      return v1::RunEnd::CANCELLED;
    case casting::RunEnd::other_version:
      return v1::RunEnd::OTHER_VERSION_FOUND;
  }
  return v1::RunEnd::OUTCOME_UNSPECIFIED;
}

v1::Finding::Kind to_proto(casting::FailureKind from) {
  switch (from) {
    case casting::FailureKind::solve_failed:
      return v1::Finding::SOLVE_FAILED;
    case casting::FailureKind::check_failed:
      return v1::Finding::CHECK_FAILED;
    case casting::FailureKind::shell_melted_through:
      return v1::Finding::SHELL_MELTED_THROUGH;
    case casting::FailureKind::motion_too_large:
      return v1::Finding::MOTION_TOO_LARGE;
    case casting::FailureKind::storage:
      return v1::Finding::STORAGE;
    case casting::FailureKind::other_version:
      return v1::Finding::OTHER_VERSION;
  }
  return v1::Finding::KIND_UNSPECIFIED;
}

v1::Finding::Severity to_proto(results::Severity from) {
  switch (from) {
    case results::Severity::note:
      return v1::Finding::NOTE;
    case results::Severity::warning:
      return v1::Finding::WARNING;
    case results::Severity::danger:
      return v1::Finding::DANGER;
  }
  return v1::Finding::SEVERITY_UNSPECIFIED;
}

v1::Finding::Certainty to_proto(results::Certainty from) {
  switch (from) {
    case results::Certainty::open:
      return v1::Finding::OPEN;
    case results::Certainty::likely:
      return v1::Finding::LIKELY;
    case results::Certainty::sure:
      return v1::Finding::SURE;
  }
  return v1::Finding::CERTAINTY_UNSPECIFIED;
}

}  // namespace dccast::translate
