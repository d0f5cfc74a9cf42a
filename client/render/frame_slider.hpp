#pragma once

#include <optional>
#include <string>
#include <vector>

#include "client/frame_series.hpp"
#include "client/render/curl_history.hpp"
#include "client/render/picture_view.hpp"

namespace dccast::client::render {

/// "250.0 s, cast length 206.7 mm"
std::string when_text(const v1::Frame& frame);

/// The range of temperatures of all frames; nothing where there are fewer than two.
std::optional<ColourRange> colour_range(const FrameSeries& series);

/// A slider over the frames with what is drawn by it: the control, the frames as numbers and the
/// script that draws them into the groups of class "now" of the pictures before it. The last frame
/// stays the picture that is there; without a script, and on paper, it is the only one. Empty where
/// there are fewer than two frames, or one that cannot be drawn.
/// @param views  of the pictures, in their order
/// @param scale  factor on the displacements in them
std::string frame_slider(const FrameSeries& series, const CurlHistory& history,
                         const std::vector<PictureView>& views, double scale);

}  // namespace dccast::client::render
