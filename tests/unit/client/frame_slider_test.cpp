#include <cmath>
#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/frame_picture.hpp"
#include "client/html/frame_surface.hpp"
#include "client/html/pages.hpp"
#include "json_reading.hpp"

namespace dccast::client::render {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;
using testing::SizeIs;

/// A section or slab of unit cells, two across (and two deep), `rows` high; the last node has
/// moved.
v1::Frame slab(int dimension, int rows, double time_s) {
  v1::Frame frame;
  frame.set_dimension(dimension);
  frame.set_nodes_per_element(dimension == 2 ? 4 : 8);
  frame.set_time_s(time_s);
  frame.set_cast_length_m(1e-3 * time_s);
  frame.set_solidus_c(620);
  frame.set_liquidus_c(649);

  // Nodes row by row, warmer upwards and outwards.
  const int depth = dimension == 2 ? 1 : 3, plan = 3 * depth;
  for (int k = 0; k <= rows; ++k)
    for (int j = 0; j < depth; ++j)
      for (int i = 0; i < 3; ++i) {
        frame.add_node_m(i);
        if (dimension == 3) frame.add_node_m(j);
        frame.add_node_m(k);
        frame.add_temperature_c(100.0 + 500.0 * k / rows + 10.0 * i);
        for (int c = 0; c < dimension; ++c) frame.add_displacement_m(0.0);
      }

  frame.set_displacement_m(frame.displacement_m_size() - 1, 0.25);

  // Cells between the rows.
  for (int k = 0; k < rows; ++k)
    for (int j = 0; j < std::max(1, depth - 1); ++j)
      for (int i = 0; i < 2; ++i) {
        const int n = plan * k + 3 * j + i;
        const std::vector<int> across =
            dimension == 2 ? std::vector{n, n + 1, n + plan + 1, n + plan}
                           : std::vector{n,        n + 1,        n + 4,        n + 3,
                                         n + plan, n + plan + 1, n + plan + 4, n + plan + 3};
        for (const int node : across) frame.add_element_node(node);
      }

  return frame;
}

FrameSeries growing(int dimension) {
  return {.stored = 7,
          .frames = {slab(dimension, 1, 0.0), slab(dimension, 2, 10.0), slab(dimension, 4, 30.0)}};
}

std::string slider_of(const FrameSeries& series, const CurlHistory& history = {}) {
  return drawn_frames(series, history, {.pictures = {{}}});
}

ReadJson numbers_in(const std::string& html) {
  std::smatch found;
  const bool there = std::regex_search(
      html, found, std::regex("<script type='application/json' class='frames'>([^<]*)</script>"));
  return there ? ReadJson::parse(found.str(1)) : ReadJson();
}

/// The numbers of a text in base64, two bytes each, the lower one first.
std::vector<int> decoded(const std::string& text) {
  std::vector<int> bytes;
  int bits = 0, held = 0;
  for (const char c : text) {
    if (c == '=') break;
    const auto digit =
        std::string("ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/").find(c);
    held = held << 6 | static_cast<int>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes.push_back(held >> bits & 0xff);
    held &= (1 << bits) - 1;
  }
  std::vector<int> numbers;
  for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
    numbers.push_back(bytes[i] | bytes[i + 1] << 8);
  return numbers;
}

TEST(EvenlyChosen, HasTheFirstAndTheLastAndNoneTwice) {
  EXPECT_THAT(evenly_chosen(0, 25), SizeIs(0));
  EXPECT_THAT(evenly_chosen(1, 25), ElementsAre(1));
  EXPECT_THAT(evenly_chosen(4, 25), ElementsAre(1, 2, 3, 4));
  EXPECT_THAT(evenly_chosen(101, 5), ElementsAre(1, 26, 51, 76, 101));
  const auto many = evenly_chosen(26, 25);
  EXPECT_THAT(many, SizeIs(25));
  EXPECT_EQ(many.back(), 26);
  for (std::size_t i = 1; i < many.size(); ++i) EXPECT_GT(many[i], many[i - 1]);
}

TEST(FrameSkin, OfASlabIsItsSurfaceWithItsTwelveEdges) {
  const auto skin = skin_of(slab(3, 2, 0.0));
  ASSERT_TRUE(skin);
  EXPECT_THAT(skin->faces, SizeIs(24));
  EXPECT_THAT(skin->edges, SizeIs(24));  // of two cells each

  const auto places = places_of(slab(3, 2, 0.0), 0.0);
  for (const auto& face : skin->faces) {
    Vector3 one, two, out;
    for (std::size_t c = 0; c < 3; ++c) {
      one[c] = places[face[1]][c] - places[face[0]][c];
      two[c] = places[face[2]][c] - places[face[0]][c];
      out[c] = (places[face[0]][c] + places[face[2]][c]) / 2.0 - 1.0;  // from the middle
    }
    EXPECT_GT(dot(cross(one, two), out), 0.0) << "anticlockwise from outside";
  }
}

TEST(FrameSlider, HoldsTheFramesAndLoadsNothing) {
  for (const int dimension : {2, 3}) {
    const std::string html = slider_of(growing(dimension));
    EXPECT_THAT(html, HasSubstr("max='2' value='2'"));
    EXPECT_THAT(html, HasSubstr("3 of 7 stored frames"));
    for (const char* const absent : {"http", "src=", "import", "fetch("})
      EXPECT_THAT(html, Not(HasSubstr(absent)));
    const ReadJson json = numbers_in(html);
    ASSERT_EQ(json["frames"].size(), 3u);
    EXPECT_EQ(json["frames"][1]["when"], "10.0 s, cast length 10.0 mm");
    EXPECT_EQ(json["frames"][1]["nodes"], dimension == 2 ? 9 : 27);
  }
}

TEST(FrameSlider, AMeshThatHasGrownSharesItsFaces) {
  const ReadJson section = numbers_in(slider_of(growing(2)));
  EXPECT_THAT(decoded(section["faces"]), SizeIs(4 * 8));
  for (const ReadJson& frame : section["frames"]) {
    EXPECT_FALSE(frame["all"].get<bool>());
    EXPECT_EQ(frame["own"], "");
  }
  // The face on top lies inside later.
  const ReadJson cube = numbers_in(slider_of(growing(3)));
  EXPECT_FALSE(cube["frames"][0]["all"].get<bool>());
  EXPECT_THAT(decoded(cube["frames"][0]["own"]), SizeIs(4 * 4));
}

TEST(FrameSlider, AMeshOfItsOwnBringsItsFaces) {
  FrameSeries series = growing(2);
  v1::Frame& other = series.frames[0];  // its cells begin at another corner
  for (int e = 0; e < 2; ++e)
    for (int i = 0; i < 3; ++i)
      other.mutable_element_node()->SwapElements(4 * e + i, 4 * e + i + 1);
  const ReadJson json = numbers_in(slider_of(series));
  EXPECT_TRUE(json["frames"][0]["all"].get<bool>());
  EXPECT_THAT(decoded(json["frames"][0]["own"]), SizeIs(4 * 2));
}

TEST(FrameSlider, PlacesAndTemperaturesAreThoseOfTheFrame) {
  const ReadJson json = numbers_in(slider_of(growing(2)));
  const double low = json["place"][0], high = json["place"][1];
  const double cold = json["temperature"][0], hot = json["temperature"][1];
  const auto numbers = decoded(json["frames"][1]["moving"]);
  const v1::Frame frame = slab(2, 2, 10.0);
  ASSERT_EQ(numbers.size(), 3u * 9);

  for (int node = 0; node < 9; ++node) {
    for (int c = 0; c < 2; ++c)
      EXPECT_NEAR(low + (high - low) * numbers[3 * node + c] / 65535,
                  frame.node_m(2 * node + c) + frame.displacement_m(2 * node + c),
                  (high - low) / 65535);
    EXPECT_NEAR(cold + (hot - cold) * numbers[3 * node + 2] / 65535, frame.temperature_c(node),
                (hot - cold) / 65535);
  }
}

TEST(FrameSlider, AFrameThatDoesNotFitLeavesTheLast) {
  const std::string last = "30.0 s, cast length 30.0 mm";
  FrameSeries series = growing(2);
  series.frames[0].clear_temperature_c();
  EXPECT_EQ(numbers_in(slider_of(series))["frames"].size(), 1u);
  series = growing(2);
  series.frames[1] = slab(3, 2, 10.0);
  const std::string html = slider_of(series);
  ASSERT_EQ(numbers_in(html)["frames"].size(), 1u);
  EXPECT_EQ(numbers_in(html)["frames"][0]["when"], last);
  EXPECT_THAT(html, HasSubstr("1 of 7 stored frames"));
}

TEST(FrameSlider, ThereIsNothingWithoutALastFrame) {
  EXPECT_EQ(slider_of({}), "");
  FrameSeries series = growing(2);
  series.frames.back().set_element_node(0, 99);
  EXPECT_EQ(slider_of(series), "");
}

TEST(FrameSlider, AFrameBeyondValiditySaysSo) {
  CurlHistory history;
  history.time_s = {0.0, 10.0, 30.0};
  history.beyond = {false, true, true};
  const ReadJson json = numbers_in(slider_of(growing(2), history));
  EXPECT_FALSE(json["frames"][0]["beyond"].get<bool>());
  EXPECT_TRUE(json["frames"][1]["beyond"].get<bool>());
}

TEST(PictureView, PutsNodesIntoThePicture) {
  const v1::Frame frame = slab(2, 2, 0.0);
  const FramePictures found = pictures_of(frame, {100, 620});
  const auto at = [&](const std::array<double, 4>& a, int node) {
    double sum = a[3];
    for (int c = 0; c < 2; ++c)
      sum += a[c] * (frame.node_m(2 * node + c) +
                     found.displacement_scale * frame.displacement_m(2 * node + c));
    return sum;
  };
  const PictureView& view = found.pictures.at(0).view;

  EXPECT_GT(at(view.across, 2), at(view.across, 0));
  EXPECT_LT(at(view.down, 8), at(view.down, 2)) << "up is up";

  // The foot of the picture has the tick of 0 mm, 8 units left of the symmetry plane.
  char tick[64];
  std::snprintf(tick, sizeof tick, "x='%.1f' y='%.1f'>0<", at(view.across, 0) - 8.0,
                at(view.down, 0) + 4.0);
  EXPECT_THAT(found.pictures[0].svg, HasSubstr(tick));
}

TEST(ReportPage, HasASliderOverItsFrames) {
  const FrameSeries series = growing(3);
  v1::QueryResultResponse result;
  *result.mutable_frame() = series.frames.back();
  const std::string page = report_page(v1::Job(), result, {}, series);
  EXPECT_THAT(page, HasSubstr("<div class='slider' hidden>"));
  EXPECT_EQ(numbers_in(page)["views"].size(), 3u);
  EXPECT_THAT(page, HasSubstr("<span class='when'>30.0 s, cast length 30.0 mm</span>"));
}

}  // namespace
}  // namespace dccast::client::render
