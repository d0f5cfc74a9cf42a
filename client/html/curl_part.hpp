#pragma once

#include <string>

#include "client/model/curl_history.hpp"
#include "client/model/study.hpp"
#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// One sentence about the largest curl at the end: place, value, uncertainty, and whether it is
/// within the plant's range. Empty before the first step.
std::string curl_sentence(const CurlHistory& history, const v1::QueryResultResponse& result,
                          const Study& study);

/// When half of the largest curl came, and through which faces the heat left meanwhile. Empty where
/// nothing has curled.
std::string cause_sentence(const CurlHistory& history, const v1::QueryResultResponse& result);

/// The figures of the last step in boxes, curls with their error if known.
std::string headline(const CurlHistory& history, const v1::QueryResultResponse& result,
                     const Study& study);

/// The chart of the curl against time or cast length, with the plant's range.
std::string curl_figure(const CurlHistory& history, const v1::QueryResultResponse& result,
                        const Study& study, bool against_length);

/// The remark beside a figure of the last step; empty while the model is valid.
std::string last_step_mark(const CurlHistory& history);

/// Charts against time of the quantities that decide whether a casting succeeds: shell, sump,
/// temperatures, heat through each face, and the contact of the bottom with the block. Empty with
/// fewer than two steps.
std::string history_part(const v1::QueryResultResponse& result);

}  // namespace dccast::client::render
