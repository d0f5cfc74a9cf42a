#include <filesystem>
#include <fstream>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/override.hpp"

namespace dccast::case_file {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

const std::string file_text =
    "[section]\nhalf_width = \"0.28 m\"\ninitial_depth = \"10 cm\"\n[time]\nend = \"145 s\"\n"
    "[mesh]\ncolumns = \"many\"\n[[monitor]]\nname = \"corner\"\nx = \"280 mm\"\n";

std::vector<v1::CaseChange> changes(const std::vector<std::string>& texts) {
  std::vector<v1::CaseChange> parsed;
  for (const std::string& text : texts) parsed.push_back(parse_change(text).value());
  return parsed;
}

/// A case after changes; every one must be sound.
v1::Case changed(const std::vector<std::string>& texts) {
  v1::Case description;
  for (const v1::Fault& fault : apply_changes(description, changes(texts)))
    ADD_FAILURE() << describe(fault, SourceMap());
  return description;
}

/// The faults of one change, described as the client prints them.
std::string fault_of(const std::string& text) {
  v1::Case description;
  ReadOutcome read = read_text(file_text, "my.toml", description);
  read.faults.clear();
  apply_changes(description, changes({text}), read);
  std::string found;
  for (const v1::Fault& fault : read.faults) found += describe(fault, read.source) + "\n";
  return found;
}

TEST(Override, ReadsWhatAFileHasAlsoWithoutItsQuotes) {
  const v1::Case description = changed(
      {"mesh.rows=30", "schedule.hold = \"1 min\"", "schedule.casting_temperature=953.15 K",
       "mesh.element=q1", "title=30", "mesh.growth=false", "alloy.melt_conductivity_factor=2"});
  EXPECT_EQ(description.mesh().rows(), 30);
  EXPECT_DOUBLE_EQ(description.schedule().hold_s(), 60.0);
  EXPECT_NEAR(description.schedule().casting_temperature_c().value(0), 680.0, 1e-9);
  EXPECT_EQ(description.mesh().element(), v1::Q1);
  EXPECT_EQ(description.title(), "30");
  EXPECT_FALSE(description.mesh().growth());
  EXPECT_THAT(description.alloy().melt_conductivity_factor().value(), ElementsAre(2.0));
}

TEST(Override, ReadsATableWithAndWithoutItsQuotes) {
  for (const char* const value :
       {"[[\"0 s\", \"30 mm/min\"], [\"1 min\", \"60 mm/min\"]]",
        "[[0 s, 30 mm/min], [1 min, 60 mm/min]]", "[['0 s',30 mm/min],['1 min','60 mm/min']]"}) {
    const v1::Case description = changed({std::string("schedule.casting_speed=") + value});
    const v1::Curve& speed = description.schedule().casting_speed_m_per_s();
    EXPECT_THAT(speed.at(), ElementsAre(0.0, 60.0)) << value;
    EXPECT_DOUBLE_EQ(speed.value(0), 0.0005) << value;
  }
}

TEST(Override, ReplacesAWholeTable) {
  v1::Case description = changed({"schedule.casting_speed=[[0 s, 30 mm/min], [1 min, 60 mm/min]]"});
  apply_changes(description, changes({"schedule.casting_speed=50 mm/min"}));
  EXPECT_EQ(description.schedule().casting_speed_m_per_s().value_size(), 1);
}

TEST(Override, ChangesAndAddsAMonitor) {
  v1::Case description;
  ReadOutcome read = read_text(file_text, "my.toml", description);
  apply_changes(description, changes({"monitor[0].x=5 mm", "monitor[1].name=head"}), read);
  EXPECT_EQ(description.monitor_size(), 2);
  EXPECT_DOUBLE_EQ(description.monitor(0).x_m(), 0.005);
  EXPECT_EQ(description.monitor(1).name(), "head");
}

TEST(Override, MendsAFaultOfTheFile) {
  v1::Case description;
  ReadOutcome read = read_text(file_text, "my.toml", description);
  ASSERT_THAT(read.faults, SizeIs(testing::Ge(1u)));
  apply_changes(description, changes({"mesh.columns=12", "monitor[0].y=0 mm"}), read);
  EXPECT_THAT(read.faults, IsEmpty()) << describe(read.faults.front(), read.source);
  EXPECT_EQ(description.mesh().columns(), 12);
}

TEST(Override, AFaultNamesTheChangeAndItsColumn) {
  EXPECT_THAT(fault_of("mesh.rows=thirty"),
              HasSubstr("--set mesh.rows, column 11: mesh.rows = \"thirty\": text where a whole "
                        "number is expected"));
  EXPECT_THAT(fault_of("schedule.casting_speed=60"), HasSubstr("the unit is missing"));
  EXPECT_THAT(fault_of("schedule.casting_speed=9000 mm/min"),
              HasSubstr("0 to 0.1 m/s (0 to 6000 mm/min)"));
  EXPECT_THAT(fault_of("schedule.casting_speed=[[0 s, 40 mm/min], [60 s, 6 m]]"),
              HasSubstr("--set schedule.casting_speed, column 50"));
}

TEST(Override, AFaultFoundLaterStandsAtTheChange) {
  v1::Case description;
  ReadOutcome read = read_text(file_text, "my.toml", description);
  apply_changes(description, changes({"monitor[0].x=5 mm"}), read);
  EXPECT_EQ(read.source.origin_of("monitor[0].x"), "--set monitor[0].x");
  EXPECT_EQ(read.source.find("monitor[0].x").column, 14);
  EXPECT_EQ(read.source.origin_of("monitor[0].name"), "my.toml");
}

TEST(Override, ANonexistentKeyIsNamedWithTheNearest) {
  EXPECT_THAT(fault_of("mesh.row=3"), HasSubstr("unknown key; did you mean 'rows'?"));
  EXPECT_THAT(fault_of("shedule.hold=3 s"), HasSubstr("did you mean 'schedule'?"));
  EXPECT_THAT(fault_of("casting_speed=3 m/s"), HasSubstr("there is a key schedule.casting_speed"));
}

TEST(Override, APathThatLeadsNowhereIsAFault) {
  EXPECT_THAT(fault_of("mesh={rows=3}"), HasSubstr("a table; a change sets one key"));
  EXPECT_THAT(fault_of("monitor.x=3 mm"), HasSubstr("which of them is missing"));
  EXPECT_THAT(fault_of("monitor[5].x=3 mm"), HasSubstr("monitor[0] to monitor[1]"));
  EXPECT_THAT(fault_of("mesh[0].rows=3"), HasSubstr("this table is no list"));
  EXPECT_THAT(fault_of("mesh.rows[0]=3"), HasSubstr("this key is no list"));
  for (const char* const key : {"mesh..rows", "monitor[x].x", "monitor[0", "monitor[0]x.y", "."})
    EXPECT_THAT(fault_of(std::string(key) + "=3"), HasSubstr("not the path of a key")) << key;
}

TEST(Override, TheSameKeyTwiceIsAFault) {
  v1::Case description;
  const auto faults = apply_changes(
      description, changes({"schedule.water_flow.scale=0.8", "schedule.water_flow_factor=0.7"}));
  ASSERT_THAT(faults, SizeIs(1));
  EXPECT_EQ(faults[0].message(), "is set twice");
}

TEST(Override, AServerReadsNoFileForAChange) {
  v1::Case description;
  const auto faults = apply_changes(description, changes({"mesh.file=/etc/hostname"}));
  ASSERT_THAT(faults, SizeIs(1));
  EXPECT_THAT(faults[0].message(), HasSubstr("a change cannot bring"));
  EXPECT_TRUE(description.mesh().file().empty());
}

TEST(Override, AFileTakesThePlaceOfTheOneBefore) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "override";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "new.msh") << "mesh";
  v1::Case description;
  description.mutable_mesh()->set_file("old.msh");
  ReadOutcome read;
  read.attachments.push_back({.name = "old.msh"});
  apply_changes(description, changes({"mesh.file=new.msh"}), read, folder);
  ASSERT_THAT(read.attachments, SizeIs(1));
  EXPECT_EQ(read.attachments[0].name, "new.msh");
  EXPECT_EQ(description.mesh().file(), "new.msh");
}

TEST(Override, AnotherCardTakesThePlaceOfOnesOwn) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "override_card";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "mine.toml") << "solidus = \"620 degC\"";
  v1::Case description;
  ReadOutcome read;
  apply_changes(description, changes({"alloy.card=./mine.toml"}), read, folder);
  EXPECT_EQ(description.alloy().card(), "mine.toml");
  ASSERT_THAT(read.attachments, SizeIs(1));

  apply_changes(description, changes({"alloy.card=aa5182"}), read, folder);
  EXPECT_EQ(description.alloy().card(), "aa5182");
  EXPECT_THAT(read.attachments, SizeIs(0));
  EXPECT_THAT(apply_changes(description, changes({"alloy.card=aa6063"})), SizeIs(0));
  EXPECT_THAT(apply_changes(description, changes({"alloy.card=./mine.toml"})), SizeIs(1));
}

/// The values of a case that leaves them to a card, after changes.
v1::Alloy alloy_with(const std::string& card, const std::vector<std::string>& texts) {
  v1::Case description;
  description.mutable_alloy()->set_card(card);
  ReadOutcome read;
  apply_changes(description, changes(texts), read);
  for (const v1::Fault& fault : read.faults) ADD_FAILURE() << describe(fault, read.source);
  complete_alloy(alloy_card(card).alloy, *description.mutable_alloy());
  return description.alloy();
}

TEST(Override, IsRelativeToTheCardWhereTheCaseLeavesAKeyToIt) {
  const v1::Alloy before = alloy_with("aa5182", {});
  const v1::Alloy after =
      alloy_with("aa5182", {"alloy.latent_heat.scale=0.95", "alloy.specific_heat.scale=1.1",
                            "alloy.solidus.offset=-2 K"});
  EXPECT_DOUBLE_EQ(after.latent_heat_j_per_kg(), 0.95 * before.latent_heat_j_per_kg());
  EXPECT_DOUBLE_EQ(after.solidus_c(), before.solidus_c() - 2.0);
  const auto &old_heat = before.specific_heat_j_per_kg_k(),
             &heat = after.specific_heat_j_per_kg_k();
  ASSERT_EQ(heat.value_size(), old_heat.value_size());
  EXPECT_THAT(heat.at(), testing::ElementsAreArray(old_heat.at()));
  for (int i = 0; i < heat.value_size(); ++i)
    EXPECT_DOUBLE_EQ(heat.value(i), 1.1 * old_heat.value(i));

  // The rest is that of the card; a default is a value, too.
  EXPECT_EQ(after.young_modulus_pa().value_size(), before.young_modulus_pa().value_size());
  EXPECT_DOUBLE_EQ(
      alloy_with("paper", {"alloy.shell_solid_fraction.scale=0.9"}).shell_solid_fraction(), 0.81);
}

/// Every number and table of a card, those in its tables too.
TEST(Override, ScalesEachNumberOfTheCards) {
  int scaled = 0;
  for (const std::string& name : alloy_names()) {
    const v1::Alloy card = alloy_card(name).alloy;
    std::vector<std::string> keys;
    if (card.has_latent_heat_j_per_kg()) keys.push_back("latent_heat");
    if (card.has_density_kg_per_m3()) keys.push_back("density");
    if (card.has_solid_density_kg_per_m3()) keys.push_back("solid_density");
    if (card.has_young_modulus_pa()) keys.push_back("young_modulus");
    if (card.has_norton_hoff()) keys.push_back("norton_hoff.exponent");
    if (card.has_reference_creep()) keys.push_back("reference_creep.stress");
    if (card.cold_strength().has_yield_stress_pa()) keys.push_back("cold_strength.yield_stress");
    for (const std::string& key : keys) {
      alloy_with(name, {"alloy." + key + ".scale=0.99"});
      ++scaled;
    }
  }
  EXPECT_GT(scaled, 20);
}

TEST(Override, IsRelativeToTheCardOfOnesOwn) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "override_scale";
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "mine.toml") << "solidus = \"620 degC\"\nlatent_heat = \"400 kJ/kg\"\n";
  v1::Case description;
  ReadOutcome read;
  apply_changes(description, changes({"alloy.card=./mine.toml", "alloy.latent_heat.scale=0.5"}),
                read, folder);
  for (const v1::Fault& fault : read.faults) ADD_FAILURE() << describe(fault, read.source);
  EXPECT_DOUBLE_EQ(description.alloy().latent_heat_j_per_kg(), 2e5);
}

TEST(Override, SaysWhereToFindAValueThatIsNotAtHand) {
  EXPECT_THAT(fault_of("alloy.melt_stirring.scale=2"), HasSubstr("`dccast alloys CARD` prints"));
  v1::Case description;
  description.mutable_alloy()->set_card("of-the-server");
  ReadOutcome read;
  apply_changes(description, changes({"alloy.latent_heat.scale=0.5"}), read);
  ASSERT_THAT(read.faults, SizeIs(1));
  EXPECT_THAT(read.faults[0].remedy(), HasSubstr("dccast alloys"));
}

TEST(Override, NoTextHarmsTheReader) {
  for (const std::string& value :
       {std::string("3\nrows = 4"), std::string(100000, '['), std::string("\"unclosed"),
        std::string("[[0 s, \"unclosed"), std::string("\x01\xff"), std::string(), std::string("]")})
    EXPECT_FALSE(fault_of("mesh.rows=" + value).empty());
}

TEST(Recipe, AFactorMayStandAlone) {
  const v1::Case description = changed({"schedule.casting_speed.scale=80 %"});
  const v1::Curve& factor = description.schedule().casting_speed_factor();
  EXPECT_THAT(factor.value(), ElementsAre(0.8));
}

TEST(Recipe, AFactorUntilACastLengthIsOneBehindIt) {
  const v1::Case description = changed({"schedule.water_flow.scale=0.8 until 100 mm"});
  const v1::Curve& factor = description.schedule().water_flow_factor();
  EXPECT_EQ(factor.abscissa(), v1::CAST_LENGTH);
  EXPECT_THAT(factor.value(), ElementsAre(0.8, 1.0));
  EXPECT_DOUBLE_EQ(factor.at(0), 0.1);
  EXPECT_NEAR(factor.at(1), 0.1, 2e-6);
}

TEST(Recipe, AFactorBetweenTwoTimesIsOneOutside) {
  const v1::Case description = changed({"schedule.water_flow.scale=1.2 from 20 s until 1 min"});
  const v1::Curve& factor = description.schedule().water_flow_factor();
  EXPECT_EQ(factor.abscissa(), v1::TIME);
  EXPECT_THAT(factor.value(), ElementsAre(1.0, 1.2, 1.2, 1.0));
  EXPECT_NEAR(factor.at(0), 20.0, 2e-3);
  EXPECT_DOUBLE_EQ(factor.at(1), 20.0);
  EXPECT_DOUBLE_EQ(factor.at(2), 60.0);
  EXPECT_THAT(check_ranges(description.schedule()), IsEmpty());
}

TEST(Recipe, AFactorFromATimeLasts) {
  const v1::Case description = changed({"schedule.water_flow.scale=0.5 from 20 s"});
  EXPECT_THAT(description.schedule().water_flow_factor().value(), ElementsAre(1.0, 0.5));
}

TEST(Recipe, AFactorMayBeAWholeTable) {
  const v1::Case description = changed({"schedule.water_flow.scale=[[0 mm, 0.5], [100 mm, 1.0]]"});
  EXPECT_THAT(description.schedule().water_flow_factor().value(), ElementsAre(0.5, 1.0));
}

TEST(Recipe, AShiftIsATime) {
  const v1::Case description = changed({"schedule.water_flow.shift=5 s"});
  EXPECT_DOUBLE_EQ(description.schedule().water_flow_shift_s(), 5.0);
}

TEST(Recipe, FaultsNameTheirPart) {
  EXPECT_THAT(fault_of("schedule.water_flow.scale=much"), HasSubstr("no number at its beginning"));
  EXPECT_THAT(fault_of("schedule.water_flow.scale=-1"), HasSubstr("permitted: 0 to 100"));
  EXPECT_THAT(fault_of("schedule.water_flow.scale=0.8 until 5 kg"),
              HasSubstr("column 31: schedule.water_flow_factor = \"5 kg\": unit 'kg'"));
  EXPECT_THAT(fault_of("schedule.water_flow.scale=0.8 from 20 s until 5 mm"),
              HasSubstr("of another kind"));
  EXPECT_THAT(fault_of("schedule.water_flow.scale=0.8 from 20 s until 5 s"),
              HasSubstr("not after"));
  EXPECT_THAT(fault_of("schedule.water_flow.shift=5 mm"), HasSubstr("of another kind than s"));
  EXPECT_THAT(fault_of("schedule.casting_temperature.shift=2 s"),
              HasSubstr("unknown key; permitted: schedule.casting_speed.scale"));
  EXPECT_THAT(fault_of("schedule.water_flow.scale.x=2"), HasSubstr("unknown key"));
}

}  // namespace
}  // namespace dccast::case_file
