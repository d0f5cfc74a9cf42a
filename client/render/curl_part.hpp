#pragma once

#include <string>

#include "client/render/curl_history.hpp"
#include "client/study.hpp"

namespace dccast::client::render {

/// One sentence about the largest curl at the end: where, how much, how certain, and how it lies in
/// the plant's band. Empty before the first step.
std::string curl_sentence(const CurlHistory& history, const v1::QueryResultResponse& result,
                          const Study& study);

/// The figures of the last step in boxes, curls with their error where it is known.
std::string headline(const CurlHistory& history, const v1::QueryResultResponse& result,
                     const Study& study);

/// The charts of the curl against time and cast length, with the plant's band.
std::string curl_figures(const CurlHistory& history, const v1::QueryResultResponse& result,
                         const Study& study);

/// The remark beside a figure of the last step; nothing while the model is valid.
std::string last_step_mark(const CurlHistory& history);

}  // namespace dccast::client::render
