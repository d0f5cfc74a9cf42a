#include "proto/frames/curve_value.hpp"

#include <algorithm>

namespace dccast::frames {

double curve_value(const v1::Curve& curve, double at) {
  const int count = std::min(curve.at_size(), curve.value_size());
  const auto end = curve.at().begin() + count;
  const auto right =
      static_cast<int>(std::lower_bound(curve.at().begin(), end, at) - curve.at().begin());
  if (right == 0) return curve.value(0);
  if (right == count) return curve.value(count - 1);
  const double share = (at - curve.at(right - 1)) / (curve.at(right) - curve.at(right - 1));
  return curve.value(right - 1) + share * (curve.value(right) - curve.value(right - 1));
}

}  // namespace dccast::frames
