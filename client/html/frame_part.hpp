#pragma once

#include <string>

#include "client/model/curl_history.hpp"
#include "client/session/queries.hpp"

namespace dccast::client::render {

/// The last stored frame: the picture of a 2D section, or three views of a quarter slab. A line
/// reports that there is no frame. With several frames a slider shows the earlier ones.
std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series = {});

/// Of the last stored frame, gap and pressure along the bottom of a 2D section; of a quarter slab
/// the gap map and the pull-in of the wide face. Empty without a frame.
std::string bottom_part(const v1::QueryResultResponse& result, const CurlHistory& history);

}  // namespace dccast::client::render
