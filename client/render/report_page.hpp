#pragma once

#include <string>

#include "client/study.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// One self-contained HTML page about a job: curl against time and cast length, the deformed
/// section with isotherms, gap and pressure along the bottom, the run's own checks and its inputs.
/// Nothing is loaded from elsewhere. Parts that the result does not hold (a run without frame) are
/// said to be absent. With a study of at least two runs that succeeded, curls have their error, and
/// charts the limit with its interval; else the page says which command tells them.
std::string report_page(const v1::Job& job, const v1::QueryResultResponse& result,
                        const Study& study = {});

}  // namespace dccast::client::render
