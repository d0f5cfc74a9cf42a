#include <limits>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;

v1::Case sound() {
  v1::Case message;
  message.mutable_section()->set_half_width_m(0.28);
  message.mutable_section()->set_initial_depth_m(0.1);
  message.mutable_time()->set_end_s(145.0);
  return message;
}

v1::Fault only_fault(const google::protobuf::Message& message) {
  const auto faults = check_ranges(message);
  EXPECT_EQ(faults.size(), 1u);
  return faults.empty() ? v1::Fault() : faults.front();
}

std::string written_file(const std::string& tail) {
  return tail +
         "\n[section]\nhalf_width = \"0.28 m\"\ninitial_depth = \"10 cm\"\n[time]\nend = \"145 "
         "s\"\n";
}

std::vector<v1::Fault> faults_of_file(const std::string& text) {
  v1::Case message;
  return read_text(text, "my.toml", message).faults;
}

void fill(v1::Curve& curve, int points) {
  curve.set_abscissa(v1::TIME);
  for (int i = 0; i < points; ++i) {
    curve.add_at(i);
    curve.add_value(1e-3);
  }
}

TEST(Texts, ACharacterThatActsOnATerminalIsAFaultThatNamesIt) {
  v1::Case message = sound();
  message.set_title("\x1b]0;owned\x07");
  const v1::Fault fault = only_fault(message);
  EXPECT_EQ(fault.field(), "title");
  EXPECT_EQ(fault.message(), "contains U+001B (ESC) at byte 1");
  EXPECT_THAT(fault.value(), HasSubstr("\\u{1B}]0;owned"));
  message.set_title("t");
  auto& monitor = *message.add_monitor();
  monitor.set_name("a\nb");
  monitor.set_x_m(0.0);
  monitor.set_y_m(0.0);
  EXPECT_EQ(only_fault(message).field(), "monitor[0].name");
}

TEST(SizeBounds, ATextBeyondItsBoundIsAFaultThatHoldsOnlyItsBeginning) {
  v1::Case message = sound();
  message.set_title(std::string(200, 't'));
  EXPECT_EQ(check_ranges(message).size(), 0u);
  message.set_title(std::string(5000000, 't'));
  const v1::Fault fault = only_fault(message);
  EXPECT_EQ(fault.field(), "title");
  EXPECT_LT(fault.value().size(), 70u);
  EXPECT_THAT(fault.message(), HasSubstr("5000000 bytes"));
  EXPECT_EQ(fault.permitted(), "at most 200 bytes");
  EXPECT_EQ(fault.remedy(), "shorten it");
}

TEST(SizeBounds, AFaultNeverCutsACharacter) {
  v1::DaemonConfig config;
  config.mutable_log()->set_level("x\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0");
  EXPECT_EQ(only_fault(config).value(), "\"x\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0\u00b0...\"");
}

TEST(SizeBounds, TablesAndCurvesAreCountedBeforeTheyAreLookedThrough) {
  v1::Case message = sound();
  for (int i = 0; i < 1001; ++i) message.add_monitor();
  EXPECT_EQ(only_fault(message).permitted(), "at most 1000 entries");
  message = sound();
  for (int i = 0; i < 101; ++i) message.mutable_cooling()->add_zone();
  EXPECT_EQ(only_fault(message).field(), "cooling.zone");
  message = sound();
  fill(*message.mutable_schedule()->mutable_casting_speed_m_per_s(), 10000);
  EXPECT_EQ(check_ranges(message).size(), 0u);
  fill(*message.mutable_schedule()->mutable_water_flow_m2_per_s(), 10001);
  EXPECT_EQ(only_fault(message).permitted(), "at most 10000 points");
}

TEST(SizeBounds, TheReaderHoldsThemToo) {
  std::string monitors;
  for (int i = 0; i < 1001; ++i) monitors += "[[monitor]]\n";
  std::string curve = "[schedule]\ncasting_speed = [";
  for (int i = 0; i < 10001; ++i) curve += "[\"" + std::to_string(i) + " s\", \"1 mm/s\"],\n";
  for (const std::string& text : {written_file("title = \"" + std::string(5000, 't') + "\""),
                                  written_file(monitors), written_file(curve + "]\n")}) {
    const auto faults = faults_of_file(text);
    ASSERT_EQ(faults.size(), 1u);
    EXPECT_THAT(faults[0].permitted(), HasSubstr("at most "));
  }
}

TEST(SizeBounds, EveryTextTableAndCurveOfTheSchemaHasOne) {
  for (const auto* root : {v1::Case::descriptor(), v1::DaemonConfig::descriptor()})
    for (const KeyReference& row : reference(*root)) {
      const bool sized = row.curve || row.type == "text" || row.type == "file" ||
                         row.path.ends_with("[]") || row.path.ends_with("uncertainty");
      EXPECT_EQ(!row.size.empty(), sized) << row.path;
    }
}

/// Such a case was "no faults" and failed in its first step.
TEST(CheckRanges, MetalHasAWeight) {
  v1::Case message = sound();
  message.mutable_mechanics()->set_gravity_m_per_s2(0.0);
  const v1::Fault fault = only_fault(message);
  EXPECT_EQ(fault.field(), "mechanics.gravity");
  EXPECT_EQ(fault.permitted(), "1 to 100 m/s2");
  EXPECT_THAT(fault.remedy(), HasSubstr("9.81 m/s2"));
  message.mutable_mechanics()->set_gravity_m_per_s2(9.81);
  EXPECT_TRUE(check_ranges(message).empty());
}

TEST(CheckRanges, AConstantMayNotStandAtInfinityOrNowhere) {
  for (const double at :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    v1::Case message = sound();
    auto& speed = *message.mutable_schedule()->mutable_casting_speed_m_per_s();
    speed.add_at(at);
    speed.add_value(1e-3);
    EXPECT_THAT(only_fault(message).message(), HasSubstr("not a finite number"));
  }
}

TEST(Echo, NoFaultRepeatsALongUnitValueOrKey) {
  const std::string much(100000, 'x');
  for (const std::string& line :
       {"hold = \"1 " + much + "\"", "hold = \"" + much + "\"", much + " = 1",
        "casting_speed = [[\"1 " + much + "\", 3]]", "\"" + much + "\".b = 1"})
    for (const v1::Fault& fault : faults_of_file(written_file("[schedule]\n" + line)))
      EXPECT_LT(fault.ByteSizeLong(), 1000u) << line.substr(0, 40);
  const std::string attached = "[mesh]\nfile = \"" + much + "\"";
  for (const v1::Fault& fault : faults_of_file(written_file(attached)))
    EXPECT_LT(fault.ByteSizeLong(), 1000u);
}

}  // namespace
}  // namespace dccast::case_file
