#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "client/model/measured_csv.hpp"

namespace dccast::client {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

MeasuredFile read(const std::string& text) {
  std::istringstream stream(text);
  return read_measured(stream, "curl.csv", {"corner", "tc 1"});
}

std::string fault(const std::string& text) {
  const auto faults = read(text).faults;
  return faults.empty() ? "" : faults.front();
}

TEST(MeasuredCsv, ReadsColumnsWithUnits) {
  const MeasuredFile file = read(
      "# a casting\n\ntime [min], curl corner [mm], temperature tc 1 (K)\n"
      "0, 0.0, 900\n0.5, 1.5,\n1, 2.5, 873.15\n");
  ASSERT_TRUE(file.faults.empty()) << file.faults.front();
  ASSERT_EQ(file.curves.size(), 2u);
  EXPECT_THAT(file.curves[0].time_s(), ElementsAre(0.0, 30.0, 60.0));
  EXPECT_THAT(file.curves[0].curl_m(), ElementsAre(0.0, 1.5e-3, 2.5e-3));
  EXPECT_EQ(file.curves[0].monitor(), "corner");
  EXPECT_EQ(file.curves[0].source(), "curl.csv");
  EXPECT_THAT(file.curves[1].time_s(), ElementsAre(0.0, 60.0));  // an empty cell is no reading
  EXPECT_NEAR(file.curves[1].temperature_c(1), 600.0, 1e-9);
}

TEST(MeasuredCsv, ReadsLengthsInchesAndSemicolons) {
  const MeasuredFile file = read("cast length [mm];gap corner [in]\r\n10;0.1\r\n20;0.2\r\n");
  ASSERT_TRUE(file.faults.empty()) << file.faults.front();
  EXPECT_THAT(file.curves[0].cast_length_m(), ElementsAre(0.01, 0.02));
  EXPECT_NEAR(file.curves[0].curl_m(1), 5.08e-3, 1e-12);
}

TEST(MeasuredCsv, ReadsSpellingsThatAreHarmless) {
  for (const char* text :
       {"\xEF\xBB\xBFtime [s],corner [mm]\n0,+1\n1,+2\n", "time [s],corner [mm],\n0,1,\n1,2,\n",
        "time [s],Curl corner [mm]\n0,1\xC2\xA0\n1,2,\n"}) {
    const MeasuredFile file = read(text);
    ASSERT_TRUE(file.faults.empty()) << file.faults.front();
    EXPECT_THAT(file.curves[0].curl_m(), ElementsAre(1e-3, 2e-3));
  }
}

TEST(MeasuredCsv, FaultsNameLineColumnAndWhatIsPermitted) {
  EXPECT_EQ(fault("time [s],corner [mm]\n0,0\n1,x\n"),
            "curl.csv:3:2: \"x\" is no number; permitted: digits with a point, e.g. 12.5");
  EXPECT_THAT(fault("time,corner [mm]\n"),
              HasSubstr("curl.csv:1:1: \"time\" has no unit; permitted"));
  EXPECT_THAT(fault("time [K],corner [mm]\n"), HasSubstr("is no time and no length"));
  EXPECT_THAT(fault("time [s],corner [MPa]\n"), HasSubstr("curl.csv:1:2: [MPa]"));
  EXPECT_THAT(fault("time [s],edge [mm]\n"),
              HasSubstr("\"edge\" is no monitor of the case; permitted: corner, tc 1"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,0\n1,1\n"), HasSubstr("curl.csv:3:1: 1 does not lie"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1\n"), HasSubstr("has 1 columns; permitted: 2"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,nan\n"), HasSubstr("is no number"));
  EXPECT_THAT(fault("time [s],corner [mm]\n1,2\n"), HasSubstr("has 1 readings; permitted: 2"));
  EXPECT_THAT(fault("\n# nothing\n"), HasSubstr("is empty"));
  EXPECT_THAT(fault("time [s];corner [mm]\n0;1,5\n"), HasSubstr("\"1,5\" has a decimal comma"));
  EXPECT_THAT(fault(std::string("\xFF\xFEt\0i\0", 6)), HasSubstr("the text is UTF-16"));
}

}  // namespace
}  // namespace dccast::client
