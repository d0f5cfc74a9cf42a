#pragma once

#include <string>

#include "client/model/curl_history.hpp"
#include "client/model/study.hpp"
#include "client/session/queries.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The casting recipe in plant units: a table of speed, water, metal, mould and block.
std::string recipe_part(const v1::QueryResultResponse& result);

/// Charts of speed and water in this run. Empty with fewer than two steps.
std::string recipe_charts(const v1::QueryResultResponse& result);

/// Evidence for the figures: the checks of the run, its progress, its assumptions, and the whole
/// case.
std::string run_part(const v1::Job& job, const v1::QueryResultResponse& result,
                     const CurlHistory& history);

/// A self-contained HTML page about a job, see docs/report.md. The first sheet is one page of A4 for the
/// plant: the curl, its error and cause, findings, recipe, the last frame. The next ones have the
/// histories and the basis of the figures. Nothing is loaded from elsewhere. The page states which
/// parts are missing in the result, such as frames. With a study of at least two successful runs,
/// curls have their error, and charts show the limit with its interval; otherwise the page names
/// the command that computes them.
/// @param series  frames for the slider; the last one is that of the result
std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study = {}, const FrameSeries& series = {});

}  // namespace dccast::client::render
