#include "client/html/frame_picture.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>

#include <fmt/core.h>
#include <openssl/evp.h>

#include "client/html/html_parts.hpp"
#include "client/model/json.hpp"

namespace dccast::client::render {
namespace {

using Numbers = std::vector<std::uint16_t>;
constexpr int most_numbers = 65535;

/// Bytes of the numbers, the lower one first (the order of this machine).
std::string base64(const Numbers& numbers) {
  const std::size_t bytes = 2 * numbers.size();
  std::string text((bytes + 2) / 3 * 4, '=');
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()),
                  reinterpret_cast<const unsigned char*>(numbers.data()), static_cast<int>(bytes));
  return text;
}

/// A range of values as 16-bit numbers.
struct Steps {
  double low, high;
  std::uint16_t operator()(double value) const {
    const double part = std::clamp((value - low) / (high - low), 0.0, 1.0);
    return static_cast<std::uint16_t>(std::lround(part * most_numbers));
  }
};

/// A frame reduced to its visible part.
struct SeenFrame {
  const v1::Frame* frame;
  FrameSkin skin;
  std::vector<double> place;  ///< (node, coordinate) as drawn [m]
};

std::vector<SeenFrame> seen_frames(const FrameSeries& series, double scale) {
  std::vector<SeenFrame> seen;
  const v1::Frame& last = series.frames.back();
  for (const v1::Frame& frame : series.frames) {
    auto skin = skin_of(frame);
    if (skin && frame.dimension() == last.dimension() &&
        frame.nodes_per_element() == last.nodes_per_element())
      seen.push_back({&frame, std::move(*skin), coordinates_of(frame, scale)});
  }
  if (seen.empty() || seen.back().frame != &last) return {};
  if (seen.size() < series.frames.size()) seen.erase(seen.begin(), seen.end() - 1);
  return seen;
}

/// Common quantisation of all coordinates of all frames, deformed or not, which preserves angles.
Steps steps_of_places(const std::vector<SeenFrame>& seen) {
  Steps steps{0.0, 1e-9};
  const auto take = [&steps](const auto& values) {
    for (const double value : values) {
      steps.low = std::min(steps.low, value);
      steps.high = std::max(steps.high, value);
    }
  };
  for (const SeenFrame& frame : seen) {
    take(frame.place);
    take(frame.frame->node_m());
  }
  return steps;
}

using Faces = std::vector<std::vector<int>>;

/// Node numbers in sequence; if `wide`, as two numbers each, the lower half first.
template <class Groups>
std::string indices(const Groups& groups, bool wide) {
  Numbers numbers;
  for (const auto& group : groups)
    for (const int node : group) {
      numbers.push_back(static_cast<std::uint16_t>(node & 0xffff));
      if (wide) numbers.push_back(static_cast<std::uint16_t>(node >> 16));
    }
  return base64(numbers);
}

/// Faces of the last frame that a frame with fewer nodes can share.
std::set<std::vector<int>> inherited(const Faces& last, int nodes) {
  std::set<std::vector<int>> faces;
  for (const auto& face : last)
    if (*std::ranges::max_element(face) < nodes) faces.insert(face);
  return faces;
}

/// Adds the faces of a frame: shared faces of the last frame and the additional ones if the mesh
/// has only grown since, otherwise all faces of the frame.
void add_faces(const SeenFrame& seen, const Faces& last, bool wide, Json& json) {
  const auto common = inherited(last, seen.frame->temperature_c_size());
  Faces own;
  std::size_t found = 0;
  for (const auto& face : seen.skin.faces)
    if (common.contains(face))
      ++found;
    else
      own.push_back(face);
  const bool has_all = found == common.size();
  json["own"] = indices(has_all ? own : seen.skin.faces, wide);
  json["all"] = !has_all;
}

template <class Groups>
std::set<int> nodes_of(const Groups& groups) {
  std::set<int> nodes;
  for (const auto& group : groups) nodes.insert(group.begin(), group.end());
  return nodes;
}

/// Place and temperature of every visible node, by its number.
Numbers moving_numbers(const SeenFrame& seen, const Steps& place, const Steps& temperature) {
  Numbers numbers;
  const int dimension = seen.frame->dimension();
  for (const int node : nodes_of(seen.skin.faces)) {
    for (int c = 0; c < dimension; ++c)
      numbers.push_back(place(seen.place[static_cast<std::size_t>(dimension * node + c)]));
    numbers.push_back(temperature(seen.frame->temperature_c(node)));
  }
  return numbers;
}

/// Undeformed places of the nodes of the outline.
Numbers still_numbers(const SeenFrame& seen, const Steps& place) {
  Numbers numbers;
  const int dimension = seen.frame->dimension();
  for (const int node : nodes_of(seen.skin.edges))
    for (int c = 0; c < dimension; ++c)
      numbers.push_back(place(seen.frame->node_m(dimension * node + c)));
  return numbers;
}

Json frame_json(const SeenFrame& seen, const Faces& last, const Steps& place,
                const Steps& temperature, bool wide, const CurlHistory& history) {
  const v1::Frame& frame = *seen.frame;
  const auto first = history.first_beyond();
  Json json{{"when", when_text(frame)},
            {"beyond", first && frame.time_s() >= history.time_s[*first]},
            {"nodes", frame.temperature_c_size()},
            {"moving", base64(moving_numbers(seen, place, temperature))},
            {"edges", indices(seen.skin.edges, wide)},
            {"still", base64(still_numbers(seen, place))}};
  add_faces(seen, last, wide, json);
  return json;
}

Json views_json(const FramePictures& pictures) {
  Json json = Json::array();
  for (const Picture& picture : pictures.pictures)
    json.push_back({{"across", picture.view.across},
                    {"down", picture.view.down},
                    {"to", picture.view.to_viewer}});
  return json;
}

Json series_json(const std::vector<SeenFrame>& seen, const CurlHistory& history,
                 const FramePictures& pictures, const ColourBands& bands) {
  const Steps place = steps_of_places(seen), temperature{bands.low, bands.high};
  const v1::Frame& last = *seen.back().frame;
  const Faces& faces = seen.back().skin.faces;
  const bool wide = std::ranges::any_of(seen, [](const SeenFrame& frame) {
    return frame.frame->temperature_c_size() > most_numbers;
  });
  Json json{{"dimension", last.dimension()},
            {"corners", faces.front().size()},
            {"place", {place.low, place.high}},
            {"temperature", {bands.low, bands.high}},
            {"fronts", {last.solidus_c(), last.liquidus_c()}},
            {"colours", Json::array()},
            {"views", views_json(pictures)},
            {"wide", wide},
            {"faces", indices(faces, wide)},
            {"frames", Json::array()}};
  for (int band = 0; band < bands.count; ++band) json["colours"].push_back(bands.colour(band));
  for (const SeenFrame& frame : seen)
    json["frames"].push_back(frame_json(frame, faces, place, temperature, wide, history));
  return json;
}

}  // namespace

std::string when_text(const v1::Frame& frame) {
  return fmt::format("{:.1f} s, cast length {:.1f} mm", frame.time_s(),
                     1e3 * frame.cast_length_m());
}

std::optional<ColourBands> colour_range(const FrameSeries& series) {
  ColourBands range{1e300, -1e300};
  for (const v1::Frame& frame : series.frames)
    for (const double value : frame.temperature_c()) {
      range.low = std::min(range.low, value);
      range.high = std::max(range.high, value);
    }
  if (range.low > range.high) return std::nullopt;
  range.high = std::max(range.high, range.low + 1.0);
  return range;
}

std::string drawn_frames(const FrameSeries& series, const CurlHistory& history,
                         const FramePictures& pictures) {
  const auto range = colour_range(series);
  if (!range) return {};
  const auto seen = seen_frames(series, pictures.displacement_scale);
  if (seen.empty() || seen.back().skin.faces.empty()) return {};
  const bool all = seen.size() == static_cast<std::size_t>(series.stored);
  return fmt::format(
             "<noscript><p>This picture is drawn by a script.</p></noscript><div class='slider' "
             "hidden><input type='range' min='0' max='{0}' value='{0}' step='1' "
             "aria-label='Stored frame'><p><output></output> <small>{1} {2} stored "
             "frames</small></p></div><script type='application/json' class='frames'>",
             seen.size() - 1, all ? "all" : fmt::format("{} of", seen.size()), series.stored) +
         series_json(seen, history, pictures, *range).dump() + "</script><script>" + page_asset("frame_slider.js") +
         "</script>";
}

}  // namespace dccast::client::render
