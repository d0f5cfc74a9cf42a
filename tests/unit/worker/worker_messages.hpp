#pragma once

#include <cstdint>

#include "dccast/v1/worker.pb.h"

namespace dccast::worker {

/// What a worker says of a step.
inline v1::WorkerMessage step(std::int64_t number) {
  v1::WorkerMessage message;
  message.mutable_step()->set_step(number);
  return message;
}

}  // namespace dccast::worker
