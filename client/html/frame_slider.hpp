#pragma once

#include <optional>
#include <string>

#include "client/html/frame_picture.hpp"
#include "client/model/curl_history.hpp"
#include "client/session/queries.hpp"

namespace dccast::client::render {

/// "250.0 s, cast length 206.7 mm"
std::string when_text(const v1::Frame& frame);

/// The temperature range of all frames; empty without one.
std::optional<ColourRange> colour_range(const FrameSeries& series);

/// The frames as data, the script that draws the last one into the groups of class "now" of the
/// preceding pictures, and a slider with which it draws the others. On paper the last frame is
/// shown. Of frames of which one cannot be drawn, or not with the others, only the last is taken;
/// empty if that one cannot be drawn.
/// @param pictures  as pictures_of() the last frame
std::string drawn_frames(const FrameSeries& series, const CurlHistory& history,
                         const FramePictures& pictures);

}  // namespace dccast::client::render
