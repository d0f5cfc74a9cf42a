#pragma once

#include <string>

#include "client/frame_series.hpp"
#include "client/study.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// One self-contained HTML page about a job, see docs/report.md. The first sheet is for the plant:
/// findings, the curl and what it means, recipe, charts against time, the last frame. The second
/// says what the figures rest on. Nothing is loaded from elsewhere. Parts that the result does not
/// hold (a run without frame) are said to be absent. With a study of at least two runs that
/// succeeded, curls have their error, and charts the limit with its interval; else the page says
/// which command tells them.
/// @param series  frames for the slider; the last one is that of the result
std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study = {}, const FrameSeries& series = {});

}  // namespace dccast::client::render
