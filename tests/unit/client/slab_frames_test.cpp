#include <regex>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/html/pages.hpp"
#include "json_reading.hpp"

namespace dccast::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::SizeIs;

/// A section or slab of unit cells, two across (and two deep), `rows` high; the last node has
/// moved. Its skin has a triangle for each cell.
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
        for (const int node : {n, n + 1, n + plan}) frame.add_skin_triangle(node);
      }

  return frame;
}

FrameSeries growing(int dimension) {
  return {.stored = 7,
          .frames = {slab(dimension, 1, 0.0), slab(dimension, 2, 10.0), slab(dimension, 4, 30.0)},
          .fields = {}};
}

/// A report of the last frame with the data that its script draws.
struct SlabPage {
  std::string html;
  ReadJson data;
};
SlabPage page_with(const FrameSeries& series, const v1::Job& job = {}) {
  v1::QueryResultResponse result;
  if (!series.frames.empty()) *result.mutable_frame() = series.frames.back();
  for (const double time_s : {0.0, 10.0, 30.0}) result.add_steps()->set_time_s(time_s);
  SlabPage page{report_page({.job = job, .result = result, .series = series}), {}};
  std::smatch found;
  if (std::regex_search(page.html, found, std::regex("data-kind='slab'><script[^>]*>([^<]*)<")))
    page.data = ReadJson::parse(found.str(1));
  return page;
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

TEST(SlabOfAReport, HasItsFramesAndTheFieldsOfTheLast) {
  for (const int dimension : {2, 3}) {
    FrameSeries series = growing(dimension);
    v1::FrameField& stress = series.fields.emplace_back();
    stress.set_name("von_mises_pa");
    stress.add_values(1e6F);
    const SlabPage page = page_with(series);
    EXPECT_THAT(page.html, HasSubstr("at 30.0 s, cast length 30.0 mm; 3 of 7 stored frames"));
    EXPECT_EQ(page.data["times"], (std::vector{0.0, 10.0, 30.0}));
    EXPECT_EQ(page.data["frames"].size(), 3u);
    EXPECT_EQ(page.data["fields"][0]["name"], "von_mises_pa");
    EXPECT_THAT(page.data["values"]["von_mises_pa"].get<std::string>(),
                testing::StartsWith("H4sI"));  // gzip
    EXPECT_FALSE(page.data.contains("beyond_s"));
  }
}

TEST(SlabOfAReport, AFrameThatDoesNotFitIsLeftOut) {
  FrameSeries series = growing(2);
  series.frames[0].clear_temperature_c();
  EXPECT_EQ(page_with(series).data["times"], (std::vector{10.0, 30.0}));
  series.frames.back().set_element_node(0, 99);
  EXPECT_THAT(page_with(series).html, HasSubstr("cannot be drawn"));
  EXPECT_THAT(page_with({}).html, HasSubstr("No stored frame"));
}

TEST(SlabOfAReport, AFrameBeyondValiditySaysSo) {
  v1::Job job;
  job.mutable_validity_loss()->set_time_s(10.0);
  const SlabPage page = page_with(growing(2), job);
  EXPECT_EQ(page.data["beyond_s"], 10.0);
  EXPECT_THAT(page.html, HasSubstr("<strong>Beyond validity.</strong> The last frame"));
}

}  // namespace
}  // namespace dccast::client
