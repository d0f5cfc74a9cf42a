#pragma once

#include "core/case/case.hpp"
#include "dccast/v1/case.pb.h"

/// Parts of to_core(): SI units and degrees Celsius on both sides.
namespace dccast::translate {

casting::Schedule schedule_to_core(const v1::Schedule& from);
thermal::CoolingSpec cooling_to_core(const v1::Cooling& from);
/// @param complete  its section decides the kinematics where the case leaves it open
casting::MechanicsCase mechanics_to_core(const v1::Case& complete);

}  // namespace dccast::translate
