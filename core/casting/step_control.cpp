#include "core/casting/step_control.hpp"

namespace dccast::casting {

void StepControl::accepted() {
  constexpr double recovery = 2.0;
  if (limit_ < unlimited) limit_ *= recovery;
}

bool StepControl::rejected(double step) {
  constexpr double cut = 0.5;
  limit_ = cut * step;
  return limit_ >= smallest_;
}

}  // namespace dccast::casting
