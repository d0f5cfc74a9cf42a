#pragma once

#include "dccast/v1/case.pb.h"

namespace dccast::frames {

/// A table at a place of its abscissa, linear between its points and constant outside.
/// @pre  it has a value; one without places is constant
double curve_value(const v1::Curve& curve, double at);

}  // namespace dccast::frames
