#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/html/picture_view.hpp"
#include "client/model/curl_history.hpp"
#include "client/session/frames.hpp"

namespace dccast::client::render {

/// "250.0 s, cast length 206.7 mm"
std::string when_text(const v1::Frame& frame);

/// The temperature range of all frames; empty if there are fewer than two.
std::optional<ColourRange> colour_range(const FrameSeries& series);

/// A slider over the frames: the control, the data of the frames and the script that draws them
/// into the groups of class "now" of the preceding pictures. Initially the pictures show the last
/// frame; without scripts, and on paper, it is the only one. Empty if there are fewer than two
/// frames, or one that cannot be drawn.
/// @param views  views of the pictures, in order
/// @param scale  magnification of the displacements [1]
std::string frame_slider(const FrameSeries& series, const CurlHistory& history,
                         const std::vector<PictureView>& views, double scale);

}  // namespace dccast::client::render
