#include "client/session/readings_csv.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::Reading reading_of(ReadingsTable& table, const std::string& line) {
  const ReadingsTable::Line taken = table.take(line);
  EXPECT_THAT(taken.remarks, IsEmpty()) << line;
  return taken.reading.value_or(v1::Reading());
}

TEST(ReadingsTable, ConvertsTheUnitsOfAPlant) {
  ReadingsTable table;
  EXPECT_FALSE(table.take("# line 4").reading);
  EXPECT_FALSE(table.has_header());
  EXPECT_FALSE(
      table.take("time [min]; speed [mm/min]; water [l/min/m]; narrow water [l/min/m]; metal [K]")
          .reading);
  EXPECT_TRUE(table.has_header());

  const v1::Reading reading = reading_of(table, "0.5; 60; 90; 120; 953.15");
  EXPECT_DOUBLE_EQ(reading.time_s(), 30.0);
  EXPECT_DOUBLE_EQ(reading.casting_speed_m_per_s(), 1e-3);
  EXPECT_DOUBLE_EQ(reading.water_flow_m2_per_s(), 1.5e-3);
  EXPECT_DOUBLE_EQ(reading.narrow_water_flow_m2_per_s(), 2e-3);
  EXPECT_NEAR(reading.casting_temperature_c(), 680.0, 1e-9);
}

TEST(ReadingsTable, ReadsTheCurlOfEachGauge) {
  ReadingsTable table;
  table.take("time [s], curl corner [mm], curl middle of the wide face [cm]");
  EXPECT_THAT(table.gauges(), ElementsAre("corner", "middle of the wide face"));
  const v1::Reading reading = reading_of(table, "1, 4.5, 0.2");
  ASSERT_EQ(reading.curls_size(), 2);
  EXPECT_EQ(reading.curls(0).monitor(), "corner");
  EXPECT_DOUBLE_EQ(reading.curls(0).curl_m(), 4.5e-3);
  EXPECT_DOUBLE_EQ(reading.curls(1).curl_m(), 2e-3);
}

TEST(ReadingsTable, AnEmptyCellIsNoReading) {
  ReadingsTable table;
  table.take("time [s], casting speed [m/s], water [m2/s]");
  const v1::Reading reading = reading_of(table, "1,, 0.002");
  EXPECT_FALSE(reading.has_casting_speed_m_per_s());
  EXPECT_EQ(reading.water_flow_m2_per_s(), 0.002);
}

TEST(ReadingsTable, SaysWhatItLeavesOut) {
  ReadingsTable table;
  EXPECT_THAT(table.take("time [s], speed [mm/min], level [mm], operator").remarks,
              ElementsAre("columns that are left out: \"level [mm]\", \"operator\""));
  table.take("1, 40, 2, x");
  EXPECT_THAT(table.take("1, 40, 2, x").remarks,
              ElementsAre("line 3: left out: 1 s is not later than 1 s"));
  EXPECT_THAT(table.take("2, forty, 2, x").remarks,
              ElementsAre("line 4: \"forty\" of speed is no number and left out"));
  EXPECT_THAT(table.take("3, 40").remarks,
              ElementsAre("line 5: left out: it has 2 columns, the header 4"));
  EXPECT_THAT(table.take(", 40, 2, x").remarks, ElementsAre("line 6: left out: it has no time"));

  const auto late = table.take("20, 40, 2, x");
  EXPECT_THAT(late.remarks,
              ElementsAre("line 7: no reading for 18 s: the plan of the case holds there"));
  EXPECT_TRUE(late.reading);
}

void expect_refused(const std::string& header, const std::string& why) {
  ReadingsTable table;
  try {
    table.take(header);
    FAIL() << header;
  } catch (const CommandFailed& failure) {
    EXPECT_EQ(failure.code(), ExitCode::invalid);
    EXPECT_THAT(failure.what(), HasSubstr(why));
  }
}

TEST(ReadingsTable, RefusesAHeaderThatNamesNoLever) {
  expect_refused("time [s], colour [mm]", "one for a lever or a curl");
  expect_refused("speed [mm/min], water [l/min/m]", "a column for the time");
  expect_refused("time [s], speed [kg]", "[kg] of \"speed\" cannot be converted to m/s");
  expect_refused("12, 40", "permitted: \"time [s]");
}

}  // namespace
}  // namespace dccast::client
