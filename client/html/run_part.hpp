#pragma once

#include <string>

#include "client/model/curl_history.hpp"

namespace dccast::client::render {

/// Evidence for the figures: the checks of the run, its progress, its assumptions, and the whole
/// case.
std::string run_part(const v1::Job& job, const v1::QueryResultResponse& result,
                     const CurlHistory& history);

}  // namespace dccast::client::render
