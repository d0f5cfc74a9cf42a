#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client_run.hpp"
#include "fake_service.hpp"
#include "json_reading.hpp"
#include "tests/unit/frames/cooled_slab.hpp"

namespace dccast::client {
namespace {

using namespace frames::testing;
using ::testing::HasSubstr;

struct ContractionCommand : ::testing::Test {
  FakeService service;
  void SetUp() override {
    service.job.set_id("job");
    service.job.set_state(v1::SUCCEEDED);
    *service.result.mutable_case_() = quarter_slab();
    *service.result.mutable_frame() = cooled(hot_above);
  }
  Result run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"contraction", "job"});
    return dccast(std::move(arguments), service.address());
  }
};

TEST_F(ContractionCommand, ShowsButtMiddleAndHead) {
  const Result result = run({});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("butt"));
  EXPECT_THAT(result.out, HasSubstr("head"));
  const double cold_mm = 300.0 * stretch(20.0);
  char text[32];
  std::snprintf(text, sizeof text, "%.2f", cold_mm);
  EXPECT_THAT(result.out, HasSubstr(text));
}

TEST_F(ContractionCommand, ShowsTheHeightsAskedForAgainstWhatIsWanted) {
  const Result result = run({"--height", "210 mm", "--wanted", "0.29 m"});
  EXPECT_EQ(result.code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("200.0"));
  EXPECT_THAT(result.out, HasSubstr("over wanted"));
  const Result refused = run({"--wanted", "0.29"});
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, HasSubstr("--wanted \"0.29\""));
}

TEST_F(ContractionCommand, JsonHasAllRowsAndNullWhereNothingIsKnown) {
  const ReadJson json = ReadJson::parse(run({"--json"}).out);
  ASSERT_EQ(json["rows"].size(), height_m.size());
  EXPECT_EQ(json["rows"][0]["x_m"].size(), along_m.size());
  EXPECT_TRUE(json["rows"][3]["half_thickness_at_20_c_m"][0].is_null());
  EXPECT_FALSE(json["rows"][3]["solid"]);
}

}  // namespace
}  // namespace dccast::client
