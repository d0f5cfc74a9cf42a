#include "proto/case_file/fingerprint.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "proto/case_file/case_file.hpp"

namespace dccast::case_file {
namespace {

/// Whether a case is the same after a change, as input, as an answer and as a casting.
struct Sameness {
  bool input, answer, casting;

  bool operator==(const Sameness&) const = default;
};

Sameness sameness_after(const std::function<void(v1::Case&)>& change) {
  v1::Case before;
  before.mutable_section()->set_half_width_m(0.28);
  v1::Case after = before;
  change(after);
  apply_defaults(before);
  apply_defaults(after);

  const auto same = [&](Same meaning) {
    return fingerprint(before, meaning) == fingerprint(after, meaning);
  };
  return {same(Same::input), same(Same::answer), same(Same::casting)};
}

TEST(Fingerprint, NoTitleCounts) {
  EXPECT_EQ(sameness_after([](v1::Case& c) { c.set_title("another"); }),
            (Sameness{true, true, true}));
}

TEST(Fingerprint, ADefaultThatIsWrittenOutIsTheSame) {
  EXPECT_EQ(sameness_after([](v1::Case& c) { c.set_quality(v1::ENGINEERING); }),
            (Sameness{true, true, true}));
}

TEST(Fingerprint, CheckpointsDoNotDetermineAnAnswer) {
  EXPECT_EQ(sameness_after([](v1::Case& c) { c.mutable_checkpoint()->set_every_steps(7); }),
            (Sameness{false, true, true}));
}

TEST(Fingerprint, RangesOfDataCountForACastingAlone) {
  const auto add_range = [](v1::Case& c) {
    c.add_uncertainty()->set_key("schedule.casting_temperature");
  };
  EXPECT_EQ(sameness_after(add_range), (Sameness{false, true, false}));
}

TEST(Fingerprint, ACastingOfAnotherQualityIsTheSame) {
  EXPECT_EQ(sameness_after([](v1::Case& c) { c.set_quality(v1::DRAFT); }),
            (Sameness{false, false, true}));
}

/// Castings of a line stay those of a recipe, whatever is asked of it.
TEST(Fingerprint, ARecipeIsWhatAPlantCasts) {
  const auto name = [](const std::function<void(v1::Case&)>& change) {
    v1::Case description;
    description.mutable_section()->set_half_width_m(0.28);
    change(description);
    apply_defaults(description);
    return fingerprint(description, Same::recipe);
  };
  const std::string recipe = name([](v1::Case&) {});
  EXPECT_EQ(name([](v1::Case& c) {
              c.set_quality(v1::DRAFT);
              c.mutable_time()->set_end_s(250.0);
              c.mutable_plausibility()->set_greatest_curl_m(0.045);
              c.add_monitor()->set_name("corner");
              c.add_uncertainty()->set_key("schedule.casting_temperature");
            }),
            recipe);
  EXPECT_NE(name([](v1::Case& c) { c.mutable_schedule()->set_hold_s(77.0); }), recipe);
}

TEST(Fingerprint, FilesCount) {
  v1::Case description;
  apply_defaults(description);
  EXPECT_NE(fingerprint(description, Same::casting, {{"slab.msh", "ab"}}),
            fingerprint(description, Same::casting, {{"slab.msh", "cd"}}));
}

}  // namespace
}  // namespace dccast::case_file
