#pragma once

#include <optional>

#include "core/casting/case/case.hpp"
#include "core/casting/findings/run_failure.hpp"
#include "core/casting/simulation.hpp"
#include "core/results/step_report.hpp"
#include "dccast/v1/case.pb.h"
#include "dccast/v1/worker.pb.h"

/// The enumerations of the schema in the core, and the other way round. Each is a switch over all
/// enumerators, which the compiler checks: one that is added to the schema does not compile before
/// it has its counterpart here. UNSPECIFIED becomes the default of the schema.
/// @throws std::logic_error  a number outside of the schema; the check of a case refuses it before
namespace dccast::translate {

Abscissa to_core(v1::Abscissa from);
mesh::SectionKind to_core(v1::Section::Kind from);
mesh::ElementKind to_core(v1::ElementKind from);
thermal::Top to_core(v1::Cooling::Top from);
mechanics::Algorithm to_core(v1::Mechanics::Algorithm from);
mechanics::Liquid to_core(v1::Mechanics::Liquid from);
mechanics::Confinement to_core(v1::Mechanics::Hold from);
casting::WhenLost to_core(v1::Validity::WhenLost from);
casting::OtherVersion to_core(v1::OtherVersion from);

/// @return nothing for both faces
std::optional<thermal::Face> to_core(v1::SideZone::Face from);

/// @return nothing where the case leaves it open: the section decides
std::optional<mechanics::Kinematics> to_core(v1::Mechanics::Kinematics from);

/// Whether a fixed volume stores heat by the mass that it holds when feeding ends.
bool is_fed(v1::Alloy::CellMass from);

/// Whether a bottom block is of steel, and not of aluminium.
bool is_steel(v1::BottomBlock::Material from);

v1::RunEnd::Outcome to_proto(casting::RunEnd from);
v1::Finding::Kind to_proto(casting::FailureKind from);
v1::Finding::Severity to_proto(results::Severity from);
v1::Finding::Certainty to_proto(results::Certainty from);

}  // namespace dccast::translate
