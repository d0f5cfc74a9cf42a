#pragma once

#include <string>

#include "client/connection.hpp"
#include "client/frame_series.hpp"

namespace dccast::client {

/// Fetches frames one by one, at most so many. @param last  an answer with the last frame and the
/// times of all
FrameSeries fetch_frames(Connection& connection, const std::string& id,
                         const v1::QueryResultResponse& last, int most);

}  // namespace dccast::client
