#pragma once

#include <string>

#include "client/render/curl_history.hpp"

namespace dccast::client::render {

/// For whoever has to trust the figures: the run's own checks, how it ran, what it assumes, and the
/// whole case.
std::string run_part(const v1::Job& job, const v1::QueryResultResponse& result,
                     const CurlHistory& history);

}  // namespace dccast::client::render
