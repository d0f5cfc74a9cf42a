#pragma once

#include <string>

#include "client/frame_series.hpp"
#include "client/render/curl_history.hpp"

namespace dccast::client::render {

/// The last stored frame: of a section its picture, gap and pressure along the bottom; of a quarter
/// slab three views, the gap map and the pull-in of the wide face. Says so when there is none. With
/// several frames a slider draws the pictures of the earlier ones.
std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series = {});

}  // namespace dccast::client::render
