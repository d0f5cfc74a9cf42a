#pragma once

#include <cstdint>

#include "dccast/v1/service.pb.h"

namespace dccast::service {

/// How large a case may be here, whatever it permits itself.
struct Ceilings {
  std::int64_t nodes = 0;  ///< at its end
  std::int64_t steps = 0;
  double memory_bytes = 0.0;  ///< as estimated
};

/// The memory each of so many workers can have on this machine: its memory, or what the control
/// group leaves of it, less a tenth for everything else.
double memory_per_worker(int workers);

/// Faults instead of the estimate when it is beyond a ceiling.
void hold_against(const Ceilings& ceilings, v1::ValidateCaseResponse& verdict);

}  // namespace dccast::service
