#pragma once

#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client {

/// Some of the frames that a job has stored, evenly chosen, the first and the last among them.
struct FrameSeries {
  int stored = 0;                 ///< frames in the results
  std::vector<v1::Frame> frames;  ///< in the order of time
};

/// Which of `stored` frames are taken where at most `most` are wanted: numbers from 1, the last one
/// always.
std::vector<int> evenly_chosen(int stored, int most);

}  // namespace dccast::client
