#pragma once

#include <string>

#include "client/model/answer.hpp"
#include "client/session/queries.hpp"
#include "dccast/v1/service.pb.h"

/// The parts of report_page().
namespace dccast::client::render {

/// The stored frames, which a script of the page draws. A line reports that there is none.
std::string frame_part(const v1::QueryResultResponse& result, const CurlHistory& history,
                       const FrameSeries& series);

/// Of the last stored frame, gap and pressure along the bottom of a 2D section; of a quarter slab
/// the gap map and the pull-in of the wide face. Empty without a frame.
std::string bottom_part(const v1::QueryResultResponse& result, const CurlHistory& history);

}  // namespace dccast::client::render
