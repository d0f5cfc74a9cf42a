#include "client/model/typed_castings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

namespace dccast::client {
namespace {

constexpr std::int64_t read_at_s = 1'790'000'000;

TypedCastings read_table(const std::string& text) {
  std::istringstream stream(text);
  return read_castings(stream, "castings.csv", read_at_s);
}

TEST(TypedCastings, ATableHasARecordForEachLine) {
  const auto found = read_table(
      "recipe; outcome; count; at; curl; sawn off; date\n"
      "# of November\n"
      "my.toml; sound; 200; ; ; ; 2026-11-20\n"
      "5f1c2a9e; bled-out; ; 40 mm; ; ;\n"
      "my.toml; ; ; ; 38 41.5 mm; 60 mm;\n");
  EXPECT_TRUE(found.faults.empty()) << found.faults.front();
  EXPECT_EQ(found.recipes, (std::vector<std::string>{"my.toml", "5f1c2a9e"}));
  ASSERT_EQ(found.castings.size(), 3u);
  EXPECT_EQ(found.castings[0].record().outcome(), v1::LineCasting::SOUND);
  EXPECT_EQ(found.castings[0].record().count(), 200);
  EXPECT_GT(found.castings[0].record().begin_time().seconds(), 0);
  EXPECT_EQ(found.castings[1].recipe(), 1);
  EXPECT_EQ(found.castings[1].record().count(), 1);
  EXPECT_DOUBLE_EQ(found.castings[1].record().at_m(), 0.04);
  EXPECT_THAT(found.castings[2].record().cold_curl_m(),
              testing::ElementsAre(testing::DoubleEq(0.038), testing::DoubleEq(0.0415)));
  EXPECT_EQ(found.lines, (std::vector<int>{3, 4, 5}));
}

TEST(TypedCastings, AllFaultsComeAtOnceWithTheirLines) {
  const auto found = read_table(
      "recipe, outcome, count, at, curl\n"
      "my.toml, fine, 200, , \n"
      ", sound, many, , \n"
      "my.toml, bled-out, 1, 40 kg, 38 41\n");
  EXPECT_THAT(found.faults,
              testing::ElementsAre(testing::AllOf(testing::HasSubstr("castings.csv:2"),
                                                  testing::HasSubstr("outcome = fine"),
                                                  testing::HasSubstr("bled-out")),
                                   testing::HasSubstr("castings.csv:3: recipe"),
                                   testing::HasSubstr("castings.csv:3: count = many"),
                                   testing::HasSubstr("castings.csv:4: at = 40 kg"),
                                   testing::HasSubstr("castings.csv:4: curl = 38 41")));
}

TEST(TypedCastings, ATableWithoutRecipesIsRefused) {
  EXPECT_THAT(read_table("outcome, weather\nsound, fine\n").faults,
              testing::ElementsAre(testing::HasSubstr("weather"), testing::HasSubstr("recipe")));
  EXPECT_THAT(read_table("").faults, testing::ElementsAre(testing::HasSubstr("no casting")));
}

}  // namespace
}  // namespace dccast::client
