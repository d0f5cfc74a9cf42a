#pragma once

#include <string>

#include "client/connection.hpp"
#include "client/frame_series.hpp"

namespace dccast::client {

/// Fetches a limited number of frames one by one.
/// @param last  a response with the last frame and the times of all frames
FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most);

}  // namespace dccast::client
