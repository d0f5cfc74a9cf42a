#include "client/session/readings_table.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

v1::Reading reading_of(ReadingsTable& table, const std::string& line) {
  const ReadingsTable::Line taken = table.take(line);
  EXPECT_THAT(taken.remarks, IsEmpty()) << line;
  return taken.readings.empty() ? v1::Reading() : taken.readings.front().reading;
}

TEST(ReadingsTable, ConvertsTheUnitsOfAPlant) {
  ReadingsTable table;
  EXPECT_THAT(table.take("# line 4").readings, IsEmpty());
  EXPECT_FALSE(table.has_header());
  EXPECT_THAT(
      table.take("time [min]; speed [mm/min]; water [l/min/m]; narrow water [l/min/m]; metal [K]")
          .readings,
      IsEmpty());
  EXPECT_TRUE(table.has_header());

  const v1::Reading reading = reading_of(table, "0.5; 60; 90; 120; 953.15");
  EXPECT_DOUBLE_EQ(reading.time_s(), 30.0);
  EXPECT_DOUBLE_EQ(reading.casting_speed_m_per_s(), 1e-3);
  EXPECT_DOUBLE_EQ(reading.water_flow_m2_per_s(), 1.5e-3);
  EXPECT_DOUBLE_EQ(reading.narrow_water_flow_m2_per_s(), 2e-3);
  EXPECT_NEAR(reading.casting_temperature_c(), 680.0, 1e-9);
}

TEST(ReadingsTable, ReadsWaterTemperatureAndLevel) {
  ReadingsTable table;
  table.take("time [s]; water temperature [K]; metal level [mm]");
  const v1::Reading reading = reading_of(table, "1; 298.15; -3");
  EXPECT_NEAR(reading.water_temperature_c(), 25.0, 1e-9);
  EXPECT_DOUBLE_EQ(reading.metal_level_m(), -3e-3);
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
              ElementsAre("line 4: \"forty\" of speed [mm/min] is no number and left out"));
  EXPECT_THAT(table.take("3, 40").remarks,
              ElementsAre("line 5: left out: it has 2 columns, the header 4"));
  EXPECT_THAT(table.take(", 40, 2, x").remarks, ElementsAre("line 6: left out: it has no time"));

  const auto late = table.take("20, 40, 2, x");
  EXPECT_THAT(late.remarks,
              ElementsAre("line 7: no reading for 18 s: the plan of the case holds there"));
  EXPECT_EQ(late.readings.size(), 1u);
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

TEST(ReadingsTable, AColumnGivenTwiceIsRefused) {
  expect_refused("time [s], speed [mm/min], casting speed [m/s]",
                 "\"speed [mm/min]\" and \"casting speed [m/s]\" measure the same");
  expect_refused("time [s], speed [mm/min], cast length [mm]", "leave one of them out");
}

TEST(ReadingsTable, ReadsObjectsWithTheSameNames) {
  ReadingsTable table;
  const auto first =
      table.take(R"({"time [s]": 1, "speed [mm/min]": 60, "curl corner [mm]": "4.5", "batch": 7})");
  EXPECT_THAT(first.remarks, ElementsAre("columns that are left out: \"batch\""));
  ASSERT_EQ(first.readings.size(), 1u);
  EXPECT_DOUBLE_EQ(first.readings[0].reading.casting_speed_m_per_s(), 1e-3);
  EXPECT_DOUBLE_EQ(first.readings[0].reading.curls(0).curl_m(), 4.5e-3);
  EXPECT_THAT(table.gauges(), ElementsAre("corner"));

  const v1::Reading next = reading_of(table, R"({"speed [mm/min]": null, "time [s]": 2.5})");
  EXPECT_EQ(next.time_s(), 2.5);
  EXPECT_FALSE(next.has_casting_speed_m_per_s());
}

TEST(ReadingsTable, SaysWhatIsWrongWithAnObject) {
  ReadingsTable table;
  table.take(R"({"time [s]": 1, "speed [mm/min]": 60})");
  const auto remark = [&](const std::string& line) { return table.take(line).fault; };
  EXPECT_EQ(remark(R"({"time [s]": 2, "speed [mm/min]": 6)"),
            "line 2: left out: it is no complete JSON object");
  EXPECT_EQ(remark(R"({"time [s]": 2, "speed [mm/min]": {"value": 60}})"),
            "line 3: \"{...}\" of speed [mm/min] is no number and left out");
  EXPECT_EQ(remark(R"({"time [s]": true, "speed [mm/min]": 60})"),
            "line 4: \"true\" of time [s] is no number and left out");
  EXPECT_EQ(remark(R"({"time [s]": 1e999, "speed [mm/min]": 60})"),
            "line 5: left out: it is no complete JSON object");
  EXPECT_EQ(remark("4, 40"), "line 6: left out: it is no JSON object, as the lines before are");
  EXPECT_EQ(remark("{}"), "line 7: left out: it has no time");

  const std::string nested(60000, '[');
  EXPECT_EQ(remark(R"({"time [s]": )" + nested), "line 8: left out: it is no complete JSON object");
  EXPECT_EQ(remark(R"({"time [s]": 9, "x": )" + nested + std::string(nested.size(), ']') + "}"),
            "line 9: left out: longer than 65536 bytes");
  EXPECT_EQ(reading_of(table, R"({"time [s]": 10, "speed [mm/min]": 60})").time_s(), 10.0);
}

/// Spellings of programs that write tables, each of which has one meaning.
TEST(ReadingsTable, ReadsSpellingsThatAreHarmless) {
  const std::string header = "time [s], speed [mm/min], metal [degC]";
  const std::pair<std::string, std::string> tables[] = {
      {"\xEF\xBB\xBF" + header, "-1, 60, 680"},
      {"\xEF\xBB\xBF\"time [s]\", \"speed [mm/min]\", \"metal [degC]\"", "\"-1\", \"60\", \"680\""},
      {header, "-1, 60, 680,"},
      {header, "-1, 60, 680,,  ,"},
      {header + ",", "-1, 60, 680,"},
      {header + ",", "-1, 60, 680"},
      {"time [s]\tspeed [mm/min]\tmetal [degC]\t", "-1\t60\t680\t"},
      {"time [s];speed [mm/min];metal [degC]", "-1;60;680;\r"},
      {header, "-1, +60, +680.0"},
      {header,
       "-1\xC2\xA0, 60\xE2\x80\xAF, \xC2\xA0"
       "680\xC2\xA0"},
      {"Time [s], SPEED [mm/min], Casting Temperature [degC]", "-1, 60, 680"}};
  for (const auto& [first, row] : tables) {
    ReadingsTable table;
    EXPECT_THAT(table.take(first).remarks, IsEmpty()) << first;
    const v1::Reading reading = reading_of(table, row);
    EXPECT_EQ(reading.time_s(), -1.0) << row;
    EXPECT_DOUBLE_EQ(reading.casting_speed_m_per_s(), 1e-3) << row;
    EXPECT_DOUBLE_EQ(reading.casting_temperature_c(), 680.0) << row;
  }

  ReadingsTable curls;
  curls.take("Time [s], Curl Corner [mm]");
  EXPECT_THAT(curls.gauges(), ElementsAre("Corner")) << "a monitor is named as in the case";
}

TEST(ReadingsTable, NamesTheCauseOfWhatItCannotRead) {
  const auto fault_of = [](const std::string& header, const std::string& row) {
    ReadingsTable table;
    table.take(header);
    const auto line = table.take(row);
    EXPECT_EQ(line.fault, line.remarks.empty() ? "" : line.remarks.front());
    EXPECT_FALSE(line.has_values) << row;
    return line.fault;
  };
  EXPECT_THAT(fault_of("time [s];speed [mm/min]", "-1;60,5"), HasSubstr("has a decimal comma"));
  EXPECT_THAT(fault_of("time [s]\tspeed [mm/min]", "-1,0\t60,5"), HasSubstr("has a decimal comma"));
  EXPECT_THAT(fault_of("time [s], speed [mm/min]", "-1,0, 60,5"),
              HasSubstr("has 4 columns, the header 2; numbers have a point, not a decimal comma"));
  EXPECT_THAT(fault_of("time [s], speed [mm/min]", "-1, +-60"), HasSubstr("is no number"));
  expect_refused(std::string("\xFF\xFEt\0i\0", 6), "the text is UTF-16; permitted: UTF-8");
  expect_refused(std::string("\xFE\xFF\0t\0i", 6), "the text is UTF-16");
  expect_refused(std::string("t\0i\0m\0e\0", 8), "the text is UTF-16");
}

TEST(ReadingsTable, ACellThatCannotBeReadIsNamedOnceForEachColumn) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min], metal [degC]");
  reading_of(table, "1, 40, 680");
  EXPECT_THAT(table.take("2, 41, NaN").remarks,
              ElementsAre("line 3: \"NaN\" of metal [degC] is no number and left out"));
  for (int t = 3; t < 10; ++t)
    EXPECT_DOUBLE_EQ(reading_of(table, fmt::format("{}, 4{}, NaN", t, t)).casting_speed_m_per_s(),
                     (40 + t) * 1e-3 / 60);
  EXPECT_THAT(table.take("10, ----, 680").remarks, ElementsAre(HasSubstr("of speed [mm/min]")));
  EXPECT_THAT(table.summary(),
              ElementsAre("metal [degC]: 8 cells could not be read and were left out"));
}

TEST(ReadingsTable, AnObjectMayHoldNoNumberAtAPlaceButNoNameTwice) {
  ReadingsTable table;
  table.take("\xEF\xBB\xBF{\"time [s]\": 1, \"speed [mm/min]\": 60, \"x\": {\"a\": 1}}");
  for (const char* word : {"NaN", "Infinity", "-Infinity"}) {
    ReadingsTable each;
    const auto line = each.take(fmt::format(
        R"({{"time [s]": 2, "speed [mm/min]": 60, "metal [degC]": {}, "note": "NaN \"NaN"}})",
        word));
    EXPECT_THAT(line.remarks.back(),
                HasSubstr(fmt::format("\"{}\" of metal [degC] is no number", word)));
    ASSERT_EQ(line.readings.size(), 1u);
    EXPECT_DOUBLE_EQ(line.readings[0].reading.casting_speed_m_per_s(), 1e-3);
    EXPECT_FALSE(line.readings[0].reading.has_casting_temperature_c());
  }

  const auto twice = table.take(R"({"time [s]": 3, "speed [mm/min]": 1, "speed [mm/min]": 2})");
  EXPECT_THAT(twice.remarks,
              ElementsAre("line 2: left out: \"speed [mm/min]\" is there twice; give "
                          "each value a name of its own"));
  EXPECT_THAT(twice.readings, IsEmpty());
  EXPECT_EQ(reading_of(table, R"({"time [s]": 4, "x": {"a": 1, "b": {"a": 2}}})").time_s(), 4.0)
      << "a name within another object is another name";
}

TEST(ReadingsTable, AnObjectAmongRowsIsLeftOut) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min]");
  EXPECT_THAT(table.take(R"({"time [s]": 1})").remarks,
              ElementsAre("line 2: left out: it is a JSON object, the lines before are rows"));
}

TEST(ReadingsTable, BytesThatAreNoTextAreShownEscaped) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min]");
  EXPECT_THAT(
      table
          .take(std::string("1, 4\0"
                            "0\x1b[2J",
                            10))
          .remarks,
      ElementsAre("line 2: \"4\\u{0}0\\u{1B}[2J\" of speed [mm/min] is no number and left out"));
  EXPECT_THAT(table.take(std::string("\0\0\0", 3)).remarks,
              ElementsAre("line 3: left out: it has 1 columns, the header 2"));
  EXPECT_THAT(table.take(std::string("{\0}", 3)).remarks,
              ElementsAre("line 4: left out: it is no complete JSON object"));
}

TEST(ReadingsTable, EachKindOfFaultIsRemarkedOnceAndCounted) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min]");
  std::size_t remarks = 0;
  for (int i = 0; i < 1200; ++i)
    for (const std::string& row :
         {fmt::format("{}, 40", 30 * i), std::string("1, 40"), std::string("1, 40, 2, 3"),
          std::string(", 40"), std::string("{}")})
      remarks += table.take(row).remarks.size();
  EXPECT_EQ(remarks, 6u) << "five kinds of faults, and a sensor that repeats itself";
  EXPECT_THAT(
      table.summary(),
      ElementsAre("JSON objects among rows: 1200 in all", "gaps without a reading: 1199 in all",
                  "lines that are not later than the one before: 1199 in all",
                  "lines with another number of columns: 1200 in all",
                  "lines without a time: 1200 in all"));
}

TEST(ReadingsTable, AJumpOfTheClockIsSaidOnceAndMovesNoReading) {
  for (const double by : {874.0, -60.0, -2.0, -3600.0}) {
    ReadingsTable table;
    table.take("time [s], speed [mm/min]");
    std::vector<std::string> remarks;
    std::vector<double> times;
    for (int t = -60; t <= 30; ++t) {
      const auto line = table.take(fmt::format("{}, {}", t + (t > 5 ? by : 0.0), 40 + 0.01 * t));
      remarks.insert(remarks.end(), line.remarks.begin(), line.remarks.end());
      for (const auto& each : line.readings) times.push_back(each.reading.time_s());
    }
    EXPECT_EQ(times.back(), 30.0) << by;
    EXPECT_GE(times.size(), 90u) << by;
    ASSERT_FALSE(remarks.empty()) << by;
    EXPECT_THAT(remarks.back(), HasSubstr("the clock of the source jumps by")) << by;
  }
}

TEST(ReadingsTable, AHeaderThatIsWrittenAgainIsNoLine) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min]");
  reading_of(table, "1, 40");
  EXPECT_THAT(table.take("time [s], speed [mm/min]").remarks, IsEmpty());
  EXPECT_EQ(reading_of(table, "2, 40").time_s(), 2.0);
}

TEST(ReadingsTable, AHeaderOfANewFileMayHaveItsColumnsInAnotherOrder) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min], metal [degC]");
  reading_of(table, "1, 60, 680");
  EXPECT_THAT(table.take("\xEF\xBB\xBFmetal [degC], operator, time [s], speed [mm/min]").remarks,
              IsEmpty());
  const v1::Reading reading = reading_of(table, "681, x, 2, 60");
  EXPECT_DOUBLE_EQ(reading.casting_speed_m_per_s(), 1e-3);
  EXPECT_DOUBLE_EQ(reading.casting_temperature_c(), 681.0);
  EXPECT_THROW(table.take("time [s], speed [mm/min], metal"), CommandFailed);
}

TEST(ReadingsTable, ReportsOnceASensorThatShowsTheSameForLong) {
  ReadingsTable table;
  table.take("time [s], speed [mm/min], metal [degC]");
  std::vector<std::string> remarks;
  for (int t = -200; t <= 300; ++t) {
    const auto line = table.take(fmt::format("{}, {}, {}", t, t > 0 ? 40 + t % 3 : 0, 680));
    remarks.insert(remarks.end(), line.remarks.begin(), line.remarks.end());
    EXPECT_EQ(line.readings.front().reading.casting_temperature_c(), 680.0);
  }
  EXPECT_THAT(remarks, ElementsAre("line 322: metal [degC] has not changed at all for 120 s; it "
                                   "counts, but look whether its sensor is alive"));
}

TEST(ReadingsTable, TheSpeedFollowsFromTheCastLength) {
  ReadingsTable table;
  table.take("time [s], cast length [mm], metal [degC]");
  EXPECT_FALSE(reading_of(table, "0, 10, 680").has_casting_speed_m_per_s());
  EXPECT_DOUBLE_EQ(reading_of(table, "2, 12, 680").casting_speed_m_per_s(), 1e-3);
  EXPECT_FALSE(reading_of(table, "3, , 680").has_casting_speed_m_per_s());
  EXPECT_NEAR(reading_of(table, "4, 14, 680").casting_speed_m_per_s(), 1e-3, 1e-12);

  const auto reset = table.take("5, 0, 680");
  EXPECT_THAT(reset.remarks,
              ElementsAre(HasSubstr("falls from 14 to 0 mm; the speed is left out")));
  EXPECT_FALSE(reset.readings.front().reading.has_casting_speed_m_per_s());
  EXPECT_NEAR(reading_of(table, "6, 1, 680").casting_speed_m_per_s(), 1e-3, 1e-12);
}

/// What the server makes of readings: it interpolates the speed, and keeps one for 10 s.
class Integral {
public:
  void add(const ReadingsTable::Line& line) {
    for (const ReadingOfLine& each : line.readings) {
      const v1::Reading& reading = each.reading;
      EXPECT_GT(reading.time_s(), last_s_);
      const bool is_measured = reading.has_casting_speed_m_per_s();
      std::optional<double> speed = speed_;
      if (is_measured) speed = reading.casting_speed_m_per_s();
      if (!is_measured && reading.time_s() - measured_s_ > 10.0) speed.reset();
      if (speed && speed_ && reading.time_s() - last_s_ <= 10.0)
        length_m_ += 0.5 * (*speed + *speed_) * (reading.time_s() - last_s_);
      if (is_measured) measured_s_ = reading.time_s();
      last_s_ = reading.time_s();
      speed_ = speed;
    }
  }
  double length_m() const { return length_m_; }

private:
  double last_s_ = -1e9, measured_s_ = -1e9, length_m_ = 0.0;
  std::optional<double> speed_;
};

/// Length of a block that gathers speed for 20 s [mm].
double cast_mm(double t) {
  if (t <= 0.0) return 0.0;
  if (t < 20.0) return 0.0125 * t * t;
  return t < 60.0 ? 5.0 + 0.5 * (t - 20.0) : 25.0 + 0.8 * (t - 60.0);
}

TEST(ReadingsTable, AMeasuredLengthIsMetExactly) {
  for (const double pause_s : {1.0, 2.5, 9.0, 9.9, 25.0}) {
    ReadingsTable table;
    table.take("time [s], cast length [mm]");
    Integral server;
    double t = -40.0;
    for (; t <= 120.0; t += pause_s) {
      server.add(table.take(fmt::format("{}, {}", t, cast_mm(t))));
      EXPECT_NEAR(server.length_m(), 1e-3 * cast_mm(t), 2e-6)
          << "every " << pause_s << " s at " << t;
    }
  }
}

TEST(ReadingsTable, AGapOfYearsIsNotFilled) {
  ReadingsTable table;
  table.take("time [s], cast length [mm]");
  table.take("0, 0");
  table.take("1, 1");
  EXPECT_LE(table.take("1e9, 2").readings.size(), 2u);
}

TEST(ReadingsTable, AMeasuredLengthIsMetOverCellsThatAreMissing) {
  ReadingsTable table;
  table.take("time [s], cast length [mm], metal [degC]");
  Integral server;
  for (int t = -20; t <= 120; ++t) {
    const bool is_there = t % 7 < 3;
    server.add(table.take(is_there ? fmt::format("{}, {}, 680.{}", t, cast_mm(t), t + 20)
                                   : fmt::format("{}, , 680.{}", t, t + 20)));
    if (t % 7 == 2) {
      EXPECT_NEAR(server.length_m(), 1e-3 * cast_mm(t), 3e-6) << t;
    }
  }
}

/// The speed of a counter with steps of 5 mm is that of the block, and no row of peaks.
TEST(ReadingsTable, TheStepsOfACoarseCounterAreSpread) {
  ReadingsTable table;
  table.take("time [s], cast length [mm]");
  Integral server;
  double fastest = 0.0;
  for (int t = -20; t <= 400; ++t) {
    const double shown = 5.0 * std::floor(0.5 * std::max(t, 0) / 5.0);
    const auto line = table.take(fmt::format("{}, {}", t, shown));
    server.add(line);
    if (t > 30)
      for (const auto& each : line.readings)
        fastest = std::max(fastest, each.reading.casting_speed_m_per_s());
    EXPECT_NEAR(server.length_m(), 1e-3 * std::max(0.5 * t, 0.0), 10.1e-3) << t;
  }
  EXPECT_NEAR(server.length_m(), 0.2, 5.1e-3);
  EXPECT_NEAR(fastest, 0.5e-3, 1e-5);
}

TEST(ReadingsTable, ALengthOfABrokenSensorIsLeftOutAlone) {
  ReadingsTable table;
  table.take("time [s], cast length [mm], metal [degC]");
  reading_of(table, "0, 10, 680");
  reading_of(table, "1, 11, 680");
  for (const char* broken : {"2, -9999, 680", "3, 32767, 680"})
    EXPECT_FALSE(table.take(broken).readings.front().reading.has_casting_speed_m_per_s());
  EXPECT_NEAR(reading_of(table, "4, 14, 680").casting_speed_m_per_s(), 1e-3, 1e-12)
      << "over the gap";
}

TEST(ReadingsTable, ALengthThatTremblesAddsUpToItself) {
  ReadingsTable table;
  table.take("time [s], cast length [mm], metal [degC]");
  double cast_m = 0.0;
  for (int t = 0; t <= 100; ++t) {
    const double shown = std::max(0.0, 0.5 * (t - 50)) + (t % 2 == 0 ? 0.04 : -0.04);
    const v1::Reading reading = reading_of(table, fmt::format("{}, {}, {}", t, shown, 680 + t));
    cast_m += reading.casting_speed_m_per_s();
  }
  EXPECT_NEAR(cast_m, 0.025, 1e-9);
}

TEST(ReadingsTable, ABrokenSpeedIsNoStartOfTheBlock) {
  for (const char* broken : {"32767", "-9999", "9999"}) {
    ReadingsTable table(
        parse_columns("time = { name = \"t\", unit = \"s\", zero = \"motion\" }\n"
                      "speed = { name = \"v\", unit = \"mm/min\" }\n",
                      "plant.toml"));
    table.take("t, v");
    EXPECT_THAT(table.take("0, 0").readings, IsEmpty());
    EXPECT_THAT(table.take(fmt::format("1, {}", broken)).readings, IsEmpty());
    EXPECT_THAT(table.take("2, 0").readings, IsEmpty());
    const auto line = table.take("3, 40");
    ASSERT_EQ(line.readings.size(), 4u);
    EXPECT_EQ(line.readings[2].reading.time_s(), 0.0);
    EXPECT_EQ(line.readings[1].line, 3);
  }
}

TEST(ReadingsTable, ACounterThatStaysTellsOnlyAfterAWhileThatTheBlockStands) {
  ReadingsTable table;
  table.take("time [s], cast length [mm], metal [degC]");
  for (int t = 0; t < 10; ++t)
    EXPECT_FALSE(reading_of(table, fmt::format("{}, 5, 680", t)).has_casting_speed_m_per_s()) << t;
  const v1::Reading still = reading_of(table, "10, 5, 680");
  EXPECT_TRUE(still.has_casting_speed_m_per_s());
  EXPECT_EQ(still.casting_speed_m_per_s(), 0.0);
  // The first step of 5 mm is spread over 10 s.
  for (int t = 11; t < 20; ++t)
    EXPECT_NEAR(reading_of(table, fmt::format("{}, 10, 680.{}", t, t)).casting_speed_m_per_s(),
                5e-3 / 11.0, 1e-9);
}

const char* const names_of_plant = R"(
time  = { name = "ts", zero = "motion" }
speed = { name = "DB12.CastSpeed", unit = "mm/min" }
water = { name = "FT101", unit = "m3/h", per = "5 m" }
curl.corner = { name = "LVDT", unit = "mm" }
)";

TEST(ReadingsTable, ReadsTheNamesUnitsAndClockOfAPlant) {
  ReadingsTable table(parse_columns(names_of_plant, "plant.toml"));
  EXPECT_THAT(table.gauges(), ElementsAre("corner"));

  // While the block stands nobody knows the time of the case.
  EXPECT_THAT(table
                  .take(R"({"ts": "2026-11-27T05:00:10+01:00", "DB12.CastSpeed": 0, "FT101": 18,
                             "LVDT": 0.1})")
                  .readings,
              IsEmpty());
  const auto still = table.take(R"({"ts": "2026-11-27T04:00:11Z", "DB12.CastSpeed": 0.2})");
  EXPECT_THAT(still.readings, IsEmpty());
  EXPECT_TRUE(still.time_s);

  const auto line = table.take(R"({"ts": "2026-11-27T04:00:12.5Z", "DB12.CastSpeed": 30})");
  ASSERT_EQ(line.readings.size(), 3u);
  EXPECT_NEAR(line.readings[0].reading.time_s(), -1.0, 1e-6);
  EXPECT_DOUBLE_EQ(line.readings[0].reading.water_flow_m2_per_s(), 1e-3);
  EXPECT_EQ(line.readings[0].reading.curls(0).monitor(), "corner");
  EXPECT_NEAR(line.readings[1].reading.time_s(), 0.0, 1e-6);
  EXPECT_NEAR(line.readings[2].reading.time_s(), 1.5, 1e-6);
  EXPECT_THAT(line.remarks, ElementsAre(HasSubstr("time.zero = \"2026-11-27T04:00:11Z\"")));
}

TEST(ReadingsTable, AStartThatWasNotSeenIsNotGuessed) {
  ReadingsTable table(parse_columns(names_of_plant, "plant.toml"));
  try {
    table.take(R"({"ts": "2026-11-27T04:00:12Z", "DB12.CastSpeed": 30})");
    FAIL();
  } catch (const CommandFailed& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("time.zero = \"2026-11-27T04:00:12Z\""));
  }
}

const char* const length_of_plant = R"(
time = { name = "t", unit = "s", zero = "motion" }
length = { name = "L", unit = "mm" }
)";

TEST(ReadingsTable, FindsTheStartByTheCastLength) {
  ReadingsTable table(parse_columns(length_of_plant, "plant.toml"));
  table.take("t, L");
  for (int t = 0; t < 20; ++t) EXPECT_THAT(table.take(fmt::format("{}, 0", t)).readings, IsEmpty());
  const auto line = table.take("20, 1");
  ASSERT_EQ(line.readings.size(), 23u) << "two changes of the speed begin right after a reading";
  EXPECT_EQ(line.readings[20].reading.time_s(), 0.0);
}

TEST(ReadingsTable, ACoarseCounterOfABlockThatMovesShowsNoStart) {
  ReadingsTable table(parse_columns(length_of_plant, "plant.toml"));
  table.take("t, L");
  for (int t = 0; t < 5; ++t) table.take(fmt::format("{}, 10", t));
  EXPECT_THROW(table.take("5, 20"), CommandFailed);
}

TEST(ReadingsTable, ReadingsThatWaitTooLongAreNotLostSilently) {
  ReadingsTable table(parse_columns(names_of_plant, "plant.toml"));
  table.take("ts, DB12.CastSpeed, FT101, LVDT");
  std::vector<std::string> remarks;
  for (int i = 0; i < 3700; ++i) {
    const auto line = table.take(fmt::format("2026-11-27T{:02}:{:02}:{:02}Z, 0, 18, 0.1",
                                             4 + i / 3600, i / 60 % 60, i % 60));
    remarks.insert(remarks.end(), line.remarks.begin(), line.remarks.end());
  }
  EXPECT_THAT(remarks,
              ElementsAre("line 3602: the block has not moved for 3600 readings; older ones "
                          "are left out from now on"));
}

TEST(ReadingsTable, AnEmptyObjectIsNoHeader) {
  ReadingsTable table;
  EXPECT_THAT(table.take("{}").remarks, ElementsAre("line 1: left out: it has no time"));
  EXPECT_FALSE(table.has_header());
  EXPECT_EQ(reading_of(table, R"({"time [s]": 2, "speed [mm/min]": 60})").time_s(), 2.0);
}

TEST(ReadingsTable, ANameThatAppearsLaterIsReportedOnce) {
  ReadingsTable table;
  table.take(R"({"time [s]": 1, "speed [mm/min]": 60})");
  const char* const later = R"({"time [s]": 2, "speed [mm/min]": 60, "curl corner [mm]": 3})";
  EXPECT_THAT(
      table.take(later).remarks,
      ElementsAre("line 2: \"curl corner [mm]\" is left out: the first object does not have it; "
                  "there null stands for no value"));
  EXPECT_THAT(table.take(R"({"time [s]": 3, "speed [mm/min]": 60, "curl corner [mm]": 3})").remarks,
              IsEmpty());
}

TEST(ReadingsTable, ANameThatAHeaderHasTwiceIsRefused) {
  ReadingsTable table(parse_columns(names_of_plant, "plant.toml"));
  try {
    table.take("ts, DB12.CastSpeed, FT101, LVDT, FT101");
    FAIL();
  } catch (const CommandFailed& failure) {
    EXPECT_THAT(failure.what(), HasSubstr("\"FT101\" is there twice"));
  }
}

TEST(ReadingsTable, ANameThatTheSourceLacksIsReported) {
  ReadingsTable objects(parse_columns(names_of_plant, "plant.toml"));
  EXPECT_THAT(
      objects.take(R"({"ts": "2026-11-27 04:00:12", "DB12.CastSpeed": 0})").remarks,
      ElementsAre("line 1: there is no \"LVDT\", \"FT101\" among \"DB12.CastSpeed\", \"ts\""));

  ReadingsTable rows(parse_columns(names_of_plant, "plant.toml"));
  EXPECT_THROW(rows.take("ts, DB12.CastSpeed"), CommandFailed);
}

}  // namespace
}  // namespace dccast::client
