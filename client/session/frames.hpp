#pragma once

#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client {

/// An evenly spaced selection of the stored frames of a job, including the first and the last.
struct FrameSeries {
  int stored = 0;                 ///< frames in the results
  std::vector<v1::Frame> frames;  ///< in the order of time
};

/// Selects at most `most` of `stored` frames, always including the last; numbers from 1.
std::vector<int> evenly_chosen(int stored, int most);

/// Fetches a limited number of frames one by one.
/// @param last  a response with the last frame and the times of all frames
FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most);

}  // namespace dccast::client
