#pragma once

#include <string>

#include "client/model/curl_history.hpp"
#include "client/session/queries.hpp"

namespace dccast::client::render {

/// The last stored frame: for a 2D section its picture, and gap and pressure along the bottom; for
/// a quarter slab three views, the gap map and the pull-in of the wide face. A line reports that
/// there is no frame. With several frames a slider shows the earlier ones.
std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series = {});

}  // namespace dccast::client::render
