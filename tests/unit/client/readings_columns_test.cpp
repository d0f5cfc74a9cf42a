#include "client/session/readings_columns.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

TEST(Columns, ReadsWhatAPlantCallsItsValues) {
  const ColumnMap map = parse_columns(R"(
time = { name = "t", unit = "ms", zero = "1200 s" }
length = { name = "DB12.Length", unit = "mm" }
metal = { name = "TT3", unit = "K" }
water = { name = "FT101", unit = "m3/h", per = "5 m" }
narrow_water = { name = "FT102", unit = "l/min/m" }
[curl]
corner = { name = "LVDT 1", unit = "in" }
"middle of the wide face" = { name = "LVDT 2", unit = "mm" }
)",
                                      "plant.toml");
  EXPECT_EQ(map.zero.at_s, 1200.0);
  EXPECT_FALSE(map.zero.at_motion);
  ASSERT_EQ(map.columns.size(), 7u);
  const auto column = [&](const std::string& name) {
    const auto found = std::ranges::find(map.columns, name, &Column::name);
    return found == map.columns.end() ? Column() : *found;
  };
  EXPECT_DOUBLE_EQ(converted(1500, column("t")), 1.5);
  EXPECT_NEAR(converted(953.15, column("TT3")), 680.0, 1e-9);
  EXPECT_DOUBLE_EQ(converted(18, column("FT101")), 1e-3);
  EXPECT_DOUBLE_EQ(converted(1, column("LVDT 1")), 0.0254);
  EXPECT_EQ(column("LVDT 2").monitor, "middle of the wide face");
}

TEST(Columns, ReadsTimeStamps) {
  EXPECT_EQ(seconds_of_stamp("1970-01-01T00:01:00.5Z"), 60.5);
  EXPECT_EQ(seconds_of_stamp("1970-01-01T01:01:00+01:00"), 60.0);
  EXPECT_EQ(seconds_of_stamp("1970-01-01 00:01:00"), 60.0) << "as UTC";
  for (const char* none : {"", "12", "27.11.2026 04:00", "2026-13-01T00:00:00Z", "2026-11-27",
                           "2026-11-27T04:00:12Zx", "9999-01-01T00:00:00Z"})
    EXPECT_FALSE(seconds_of_stamp(none)) << none;

  for (const char* same :
       {"1970-01-01T01:01:00+0100", "1970-01-01 01:01:00 +0100", "1970-01-01T01:01:00+01",
        "1970-01-01T00:01:00+0000", "1969-12-31T20:01:00-0400", "1970-01-01T00:01:00,0",
        "1970-01-01 00:01:00 UTC", "1970-01-01t00:01:00z", "01.01.1970 00:01:00",
        "1.1.1970 01:01:00 +0100"})
    EXPECT_EQ(seconds_of_stamp(same), 60.0) << same;
  for (const char* ambiguous :
       {"01/02/1970 00:01:00", "10/25/2026 12:58:30 AM", "1970/01/01 00:01:00",
        "13.13.1970 00:01:00", "1970-01-01 12:01:00 PM", "1970-01-01"})
    EXPECT_FALSE(seconds_of_stamp(ambiguous)) << ambiguous;
  EXPECT_EQ(stamp_of_seconds(60.5), "1970-01-01T00:01:00.500Z");
}

std::string fault_of(const std::string& text) {
  try {
    parse_columns(text, "plant.toml");
    return "none";
  } catch (const CommandFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::invalid);
    return failure.what();
  }
}

TEST(Columns, NamesEveryFaultWithPlaceValueAndRemedy) {
  const std::string faults = fault_of(R"(time = { name = "t", unit = "kg" }
speed = { name = 3, unit = "mm/min" }
metal = "TT3"
wter = { name = "F", unit = "l/min/m" }
water = { name = "F", unit = "m3/h" }
narrow_water = { name = "G", unit = "m3/h", per = "5 kg" }
curl = { corner = { unit = "mm", range = 3 } }
)");
  for (const char* part :
       {"plant.toml:1:29: time.unit = 'kg': cannot be converted to s; permitted: a unit such as "
        "\"s\"",
        "plant.toml:2:18: speed.name = 3: permitted: a text",
        "plant.toml:3:9: metal = 'TT3': permitted: a table; write metal = { name = \"...\", unit = "
        "\"degC\" }",
        "wter = ", "did you mean \"water\"?",
        "water.unit = 'm3/h': is a flow in total; give the length that it wets, such as per",
        "narrow_water.per = '5 kg': permitted: a length above zero",
        "curl.corner.range = 3: unknown key; permitted: name, unit",
        "curl.corner = ", "name is missing"})
    EXPECT_THAT(faults, HasSubstr(part));
  EXPECT_LT(faults.find("time.unit"), faults.find("curl.corner")) << "in the order of the file";
}

TEST(Columns, WhatIsZeroOfTheTime) {
  const auto of_time = [](const std::string& time) {
    return fault_of("time = { name = \"t\", " + time +
                    " }\nspeed = { name = \"v\", unit = \"m/s\" }");
  };
  for (const char* good : {"unit = \"s\"", "zero = \"motion\"", "unit = \"s\", zero = \"motion\"",
                           "zero = \"2026-11-27 04:00:12\"", "unit = \"ms\", zero = \"12 min\"",
                           "unit = \"s\", zero = \"2026-11-27T04:00:12Z\""})
    EXPECT_EQ(of_time(good), "none") << good;
  EXPECT_THAT(of_time("zero = \"start\""), HasSubstr("time.zero = 'start': permitted: \"motion\""));
  EXPECT_THAT(of_time("zero = \"12 s\""), HasSubstr("permitted: \"motion\""));
  EXPECT_THAT(of_time("unit = \"s\", zero = \"1e300 s\""), HasSubstr("permitted: \"motion\""));
  EXPECT_THAT(fault_of("time = { name = \"t\" }"), HasSubstr("has neither unit nor zero"));
}

TEST(Columns, WhatDoesNotGoTogetherIsRefused) {
  EXPECT_THAT(fault_of(""), HasSubstr("a column for the time"));
  EXPECT_THAT(fault_of("time = { name = \"t\", unit = \"s\" }\n"
                       "speed = { name = \"v\", unit = \"m/s\" }\n"
                       "length = { name = \"l\", unit = \"m\" }"),
              HasSubstr("leave one of them out"));
  EXPECT_THAT(fault_of("time = "), HasSubstr("plant.toml:1:"));
  EXPECT_THAT(fault_of("time = " + std::string(100000, '[')), Not(HasSubstr("none")));
  EXPECT_THAT(fault_of(std::string("time\0", 5)), HasSubstr("plant.toml:1:"));
}

}  // namespace
}  // namespace dccast::client
