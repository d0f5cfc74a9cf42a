#pragma once

#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client {

/// An evenly spaced selection of the stored frames of a job, including the first and the last.
struct FrameSeries {
  int stored = 0;                 ///< frames in the results
  std::vector<v1::Frame> frames;  ///< in the order of time
};

/// Selects at most `most` of `stored` frames, always including the last; numbers from 1.
std::vector<int> evenly_chosen(int stored, int most);

}  // namespace dccast::client
