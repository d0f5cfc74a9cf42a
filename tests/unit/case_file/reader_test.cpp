#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/values/digests.hpp"

namespace dccast::case_file {
namespace {

using testing::HasSubstr;

const std::string sound_text =
    "[section]\nhalf_width = \"0.28 m\"\ninitial_depth = \"10 cm\"\n[time]\nend = \"145 s\"\n";

ReadOutcome read_lines(const std::string& text) {
  v1::Case message;
  return read_text(text, "my.toml", message);
}

/// The one fault on `field`, described as the client prints it.
std::string fault_on(const std::string& field, const std::string& text) {
  const ReadOutcome outcome = read_lines(text);
  std::string found;
  for (const v1::Fault& fault : outcome.faults)
    if (fault.field() == field) found += describe(fault, outcome.source) + "\n";
  return found;
}

TEST(Reader, ReadsUnitsEnumsCurvesAndTables) {
  v1::Case message;
  const auto outcome = read_text(sound_text +
                                     "[mesh]\nelement = \"q1\"\ncolumns = "
                                     "12\n[schedule]\ncasting_speed = [[\"0 s\", \"40 mm/min\"], "
                                     "[\"1 min\", \"60 mm/min\"]]\ncasting_temperature = \"953.15 "
                                     "K\"\n[[monitor]]\nname = \"corner\"\n"
                                     "x = \"280 mm\"\ny = \"0 m\"\n",
                                 "my.toml", message);
  EXPECT_TRUE(outcome.ok()) << describe(outcome.faults.front(), outcome.source);
  EXPECT_DOUBLE_EQ(message.section().initial_depth_m(), 0.1);
  EXPECT_EQ(message.mesh().element(), v1::Q1);
  EXPECT_EQ(message.mesh().columns(), 12);

  const v1::Curve& speed = message.schedule().casting_speed_m_per_s();
  EXPECT_EQ(speed.abscissa(), v1::TIME);
  EXPECT_THAT(speed.at(), testing::ElementsAre(0.0, 60.0));
  EXPECT_NEAR(speed.value(1), 1e-3, 1e-15);
  EXPECT_NEAR(message.schedule().casting_temperature_c().value(0), 680.0, 1e-9);
  EXPECT_NEAR(message.monitor(0).x_m(), 0.28, 1e-15);
  EXPECT_FALSE(message.mesh().has_rows()) << "no default is applied by the reader";
}

TEST(Reader, TheUnitOfTheAbscissaDecidesWhatItIs) {
  v1::Case message;
  read_text(sound_text +
                "[schedule]\nwater_flow = [[\"0 mm\", \"1e-3 m2/s\"], [\"5 cm\", \"2e-3 m2/s\"]]\n",
            "f", message);
  EXPECT_EQ(message.schedule().water_flow_m2_per_s().abscissa(), v1::CAST_LENGTH);
  EXPECT_THAT(
      fault_on(
          "schedule.water_flow[1]",
          sound_text +
              "[schedule]\nwater_flow = [[\"0 mm\", \"1e-3 m2/s\"],\n [\"5 s\", \"2e-3 m2/s\"]]\n"),
      HasSubstr("my.toml:8:"));
  EXPECT_THAT(fault_on("schedule.water_flow[0]",
                       sound_text + "[schedule]\nwater_flow = [[5, \"2e-3 m2/s\"]]\n"),
              HasSubstr("time [s], cast length [m]"));

  v1::Alloy alloy;
  read_text("melt_conductivity_factor = [[0.3, 1], [0.8, 3.0]]", "f", alloy);
  EXPECT_EQ(alloy.melt_conductivity_factor().abscissa(), v1::LIQUID_FRACTION);
}

TEST(Reader, CollectsEveryFaultWithItsPlace) {
  const std::string text =
      "[section]\n"
      "half_width = 0.28\n"          // 2: no unit
      "initial_depth = \"60 kg\"\n"  // 3: wrong kind
      "kind = \"plain_strain\"\n"    // 4: unknown choice
      "[schedule]\n"
      "casting_sped = \"60 mm/min\"\n"                                       // 6: unknown key
      "casting_speed = \"9000 mm/min\"\n"                                    // 7: out of range
      "hold = \"nan s\"\n"                                                   // 8
      "water_flow = [[\"2 s\", \"1e-3 m2/s\"], [\"1 s\", \"1e-3 m2/s\"]]\n"  // 9: not increasing
      "[mesh]\n"
      "columns = 30.5\n"  // 11: type
      "end = 3\n"         // 12: stands elsewhere
      "[time]\n";         // end is missing
  const ReadOutcome outcome = read_lines(text);
  std::string all;
  for (const v1::Fault& fault : outcome.faults) all += describe(fault, outcome.source) + "\n";
  EXPECT_EQ(outcome.faults.size(), 10u) << all;

  for (const char* const expected :
       {"my.toml:2:1: section.half_width = 0.28: the unit is missing; permitted: 0.005 to 3 m",
        "my.toml:3:1: section.initial_depth", "is of another kind than m",
        "did you mean \"plane_strain\"?", "my.toml:6:1: schedule.casting_sped",
        "did you mean 'casting_speed'?", "my.toml:7:1: schedule.casting_speed",
        "(0 to 6000 mm/min)", "my.toml:8:1", "my.toml:9:",
        "must be larger than that of the point before it", "my.toml:11:1: mesh.columns",
        "there is a key time.end", "my.toml:13:2: time.end: required key is missing"})
    EXPECT_THAT(all, HasSubstr(expected));
}

TEST(Reader, WaterOfAllFacesIsToldPerMetreOfPerimeter) {
  const auto faults_of = [](const std::string& section) {
    const ReadOutcome outcome = read_lines(
        "[schedule]\nwater_flow = \"45 m3/h\"\nnarrow_water_flow = [[\"0 s\", \"750 l/min\"]]\n"
        "[section]\n" +
        section);
    std::string all;
    for (const v1::Fault& fault : outcome.faults) all += describe(fault, outcome.source) + "\n";
    return all;
  };
  const std::string slab =
      faults_of("kind = \"quarter_slab\"\nhalf_width = \"660 mm\"\nhalf_thickness = \"285 mm\"\n");
  EXPECT_THAT(slab, HasSubstr("unit 'm3/h' is of another kind than m2/s"));
  EXPECT_THAT(slab,
              HasSubstr("45 m3/h is the flow of all faces; over the perimeter of 3.78 m it is "
                        "\"198.4 l/min/m\""));
  EXPECT_THAT(slab, HasSubstr("750 l/min is the flow of all faces; over the perimeter of 3.78 m it "
                              "is \"198.4 l/min/m\""));
  EXPECT_THAT(faults_of("half_width = \"280 mm\"\n"),
              HasSubstr("45 m3/h is the flow of all faces; divide it by their perimeter"));
}

TEST(Reader, AKeyOfTheSettingsInTheWrongPlaceIsToldItsTable) {
  const std::string text =
      "stall_timeout = \"1 s\"\n"
      "log_level = \"info\"\n"
      "workers = 4\n"
      "nonsense = 1\n"
      "[slurm]\n"
      "job = 8\n";
  v1::DaemonConfig settings;
  const ReadOutcome outcome = read_text(text, "dccastd.toml", settings);
  std::string faults;
  for (const v1::Fault& fault : outcome.faults) faults += describe(fault, outcome.source) + "\n";

  EXPECT_EQ(outcome.faults.size(), 5u) << faults;
  for (const char* const expected :
       {"dccastd.toml:1:1: stall_timeout = \"1 s\": unknown key; there is a key "
        "workers.stall_timeout",
        "log_level = \"info\": unknown key; there is a key log.level",
        "workers = 4: a number where a table is expected; write [workers] and below it its keys: "
        "count, program,",
        "nonsense = 1: unknown key; see `dccast schema --daemon`",
        "slurm.job = 8: unknown key; did you mean 'jobs'?"})
    EXPECT_THAT(faults, HasSubstr(expected));
}

TEST(Reader, ATableOfAListMayBeWrittenAsARow) {
  v1::Case message;
  const std::string text = sound_text + "[[monitor]]\nname = \"plant\"\nof = ";
  const auto outcome = read_text(text + "[[\"corner\", 2], {monitor = \"narrow\", weight = 1}]\n",
                                 "my.toml", message);
  EXPECT_TRUE(outcome.ok()) << describe(outcome.faults.front(), outcome.source);
  EXPECT_EQ(message.monitor(0).of(0).monitor(), "corner");
  EXPECT_EQ(message.monitor(0).of(0).weight(), 2.0);
  EXPECT_EQ(message.monitor(0).of(1).monitor(), "narrow");

  v1::Case again;
  EXPECT_TRUE(read_text(to_toml(message), "again.toml", again).ok());
  EXPECT_EQ(again.SerializeAsString(), message.SerializeAsString());

  EXPECT_THAT(fault_on("monitor[0].of[0]", text + "[[\"corner\"]]\n"),
              HasSubstr("a row of 1 values; permitted: [monitor, weight]"));
  EXPECT_THAT(fault_on("monitor[0].of[0].weight", text + "[[\"corner\", 0]]\n"),
              HasSubstr("weight"));
}

TEST(Ranges, AMonitorIsAPointOrAMean) {
  v1::Case message;
  read_text(sound_text + "[[monitor]]\nname = \"plant\"\nx = \"0.1 m\"\nof = [[\"corner\", 2]]\n",
            "my.toml", message);
  const auto faults = check_ranges(message);
  EXPECT_EQ(std::ranges::count(faults, "monitor[0].x", &v1::Fault::field), 1);
  EXPECT_EQ(std::ranges::count(faults, "monitor[0].y", &v1::Fault::field), 0);
}

/// Without a server, too: `validate --local` once took what every server refuses.
TEST(Reader, KeysThatDoNotGoTogetherAreAFaultWithItsPlace) {
  const std::string mean = "[[monitor]]\nname = \"mean\"\nof = [[\"corner\", 1]]\nx = \"0.2 m\"\n";
  EXPECT_EQ(fault_on("monitor[0].x", sound_text + mean),
            "my.toml:9:1: monitor[0].x: a mean of other monitors has no place; permitted: "
            "monitor[0].of, or x, y and z; leave the place out, or of\n");
}

TEST(Reader, ATableThatIsAbsentAltogetherIsReportedByItsRequiredKeys) {
  const std::string fault = fault_on("section.half_width", "[time]\nend = \"1 s\"\n");
  EXPECT_THAT(fault, HasSubstr("required key is missing"));
  EXPECT_THAT(fault, HasSubstr("my.toml:1:1"));
}

TEST(Reader, WrongTypesSayWhatIsExpected) {
  EXPECT_THAT(fault_on("section", "section = 3\n[time]\nend=\"1 s\""),
              HasSubstr("write [section]"));
  EXPECT_THAT(fault_on("monitor", sound_text + "[monitor]\nname = \"a\"\n"),
              HasSubstr("[[monitor]]"));
  EXPECT_THAT(fault_on("mesh.growth", sound_text + "[mesh]\ngrowth = \"yes\"\n"),
              HasSubstr("true or false"));
  EXPECT_THAT(fault_on("title", "title = 3\n" + sound_text), HasSubstr("text is expected"));
  EXPECT_THAT(fault_on("mesh.columns", sound_text + "[mesh]\ncolumns = 99999999999\n"),
              HasSubstr("1 to 2000"));
  EXPECT_THAT(fault_on("time.step", sound_text + "step = []\n"), HasSubstr("at least one point"));
  EXPECT_THAT(fault_on("time.step[0]", sound_text + "step = [[\"1 s\"]]\n"), HasSubstr("pair"));
}

TEST(Reader, BrokenTextsAreOneClearFault) {
  for (const std::string& text :
       {std::string(), std::string("\0\1\2", 3), std::string("title = \"\xff\""),
        std::string("[section\n"), std::string("a = 1\na = 2\n"),
        std::string(maximum_file_bytes + 1, '#'),
        "a = " + std::string(100000, '[') + std::string(100000, ']')}) {
    const auto begin = std::chrono::steady_clock::now();
    const ReadOutcome outcome = read_lines(text);
    EXPECT_FALSE(outcome.ok());
    EXPECT_GT(outcome.source.find("").line, 0);
    EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  }
  EXPECT_THAT(read_lines("[section\nx = 1").faults.front().message(), HasSubstr("not valid TOML"));
}

TEST(Reader, AManyFaultedFileIsBoundedInTimeAndFaults) {
  std::string text;
  for (int i = 0; i < 100000; ++i)
    text += "key_number_" + std::to_string(i) + " = " + std::to_string(i) + "\n";
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_LE(read_lines(text).faults.size(), 600u);
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(20));
}

TEST(Reader, AttachmentsAreReadRelativeToTheFile) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "dccast_reader_test";
  std::filesystem::create_directories(folder / "in");
  std::ofstream(folder / "in" / "slab.msh") << "mesh";
  std::ofstream(folder / "my.toml")
      << sound_text << "[mesh]\nfile = \"in/slab.msh\"\n[thermal]\nfile = \"no.h5\"\n";
  v1::Case message;
  const ReadOutcome outcome = read_file(folder / "my.toml", message);

  ASSERT_EQ(outcome.attachments.size(), 1u);
  EXPECT_EQ(outcome.attachments[0].sha256, values::sha256("mesh"));
  EXPECT_EQ(message.mesh().file(), "slab.msh");
  ASSERT_EQ(outcome.faults.size(), 1u);
  EXPECT_THAT(outcome.faults[0].message(), HasSubstr("no such file"));
  EXPECT_FALSE(read_file(folder, message).ok());
  EXPECT_FALSE(read_file(folder / "absent.toml", message).ok());

  std::filesystem::remove_all(folder);
}

TEST(Reader, ACardOfOnesOwnTravelsWithTheCase) {
  const auto folder = std::filesystem::path(testing::TempDir()) / "dccast_own_card_test";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "mine.toml") << "solidus = \"620 degC\"";
  std::ofstream(folder / "case.toml") << sound_text << "[alloy]\ncard = \"./mine.toml\"\n";
  v1::Case message;
  const ReadOutcome outcome = read_file(folder / "case.toml", message);
  ASSERT_EQ(outcome.attachments.size(), 1u);
  EXPECT_EQ(outcome.attachments[0].sha256, values::sha256("solidus = \"620 degC\""));
  EXPECT_EQ(message.alloy().card(), "mine.toml");

  // The name of a known card is no file.
  std::string named = sound_text;
  v1::Case other;
  EXPECT_TRUE(read_text(named + "[alloy]\ncard = \"aa5182\"\n", "x", other).attachments.empty());
  EXPECT_EQ(other.alloy().card(), "aa5182");
  std::filesystem::remove_all(folder);
}

TEST(Reader, WhatIsWrittenReadsBackTheSame) {
  for (const auto& shipped : shipped::case_templates()) {
    v1::Case once, twice;
    ASSERT_TRUE(read_text(shipped.text, shipped.name, once).ok());
    apply_defaults(once);
    const ReadOutcome outcome = read_text(to_toml(once), "written", twice);
    EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : describe(outcome.faults[0], outcome.source));
    EXPECT_EQ(once.SerializeAsString(), twice.SerializeAsString()) << to_toml(once);
  }
}

TEST(SourceMap, AnAbsentKeyIsShownAtItsTable) {
  const ReadOutcome outcome = read_lines(sound_text);
  EXPECT_EQ(outcome.source.find("section.half_width").line, 2);
  EXPECT_EQ(outcome.source.find("section.kind").line, 1);
  EXPECT_EQ(outcome.source.find("monitor[3].x").line, 1);
}

TEST(EditDistance, CountsSwapsOnce) {
  EXPECT_EQ(edit_distance("hodl", "hold"), 1);
  EXPECT_EQ(edit_distance("", "abc"), 3);
  EXPECT_EQ(nearest("casting_speed_m_per_s", {"casting_speed", "hold"}), "casting_speed");
  EXPECT_EQ(nearest("zzzzzz", {"hold"}), "");
}

}  // namespace
TEST(ReadElsewhere, ListsFilesAndReadsNone) {
  v1::Case description;
  const std::string text = R"([mesh]
file = "/etc/passwd"
[thermal]
file = "beside/heat.h5"
)";
  const ReadOutcome outcome = read_elsewhere(text, "case", description);
  EXPECT_EQ(description.mesh().file(), "passwd");
  EXPECT_EQ(description.thermal().file(), "heat.h5");
  EXPECT_TRUE(outcome.attachments.empty());
  EXPECT_EQ(outcome.files, (std::vector<std::string>{"/etc/passwd", "beside/heat.h5"}));
}

TEST(ReadElsewhere, RefusesTwoFilesOfOneName) {
  v1::Case description;
  const std::string text = R"([mesh]
file = "one/same"
[thermal]
file = "other/same"
)";
  const auto faults = read_elsewhere(text, "case", description).faults;
  const auto refused = std::ranges::find(faults, "thermal.file", &v1::Fault::field);
  ASSERT_NE(refused, faults.end());
  EXPECT_NE(refused->message().find("also called same"), std::string::npos);
}

}  // namespace dccast::case_file
