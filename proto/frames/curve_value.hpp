#pragma once

#include "dccast/v1/case.pb.h"

namespace dccast::frames {

/// Value of a table, linear between its points and constant outside.
/// @param at  [unit of the abscissa]
/// @return    [unit of the curve]
/// @pre       the curve has a value; without abscissae it is constant
double curve_value(const v1::Curve& curve, double at);

}  // namespace dccast::frames
