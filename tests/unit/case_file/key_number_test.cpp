#include "proto/case_file/override.hpp"

#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"

namespace dccast::case_file {
namespace {

v1::Case changed_number(const std::string& key, const std::string& value) {
  v1::Case description;
  description.add_monitor()->set_name("corner");
  v1::CaseChange change;
  change.set_key(key);
  change.set_value(value);
  EXPECT_TRUE(apply_changes(description, {change}).empty()) << key;
  return description;
}

TEST(KeyNumber, IsInTheUnitOfTheSchema) {
  const auto number = [](const std::string& key, const std::string& value) {
    return number_at(changed_number(key, value), key);
  };
  EXPECT_DOUBLE_EQ(*number("schedule.casting_speed", "60 mm/min"), 1e-3);
  EXPECT_DOUBLE_EQ(*number("section.half_width", "25 cm"), 0.25);
  EXPECT_EQ(*number("mesh.rows", "30"), 30.0);
  EXPECT_DOUBLE_EQ(*number("monitor[0].x", "3 mm"), 3e-3);
  EXPECT_DOUBLE_EQ(*number("schedule.water_flow.scale", "0.8"), 0.8);
  EXPECT_DOUBLE_EQ(*number("schedule.water_flow.shift", "5 s"), 5.0);
}

TEST(KeyNumber, TablesTextsAndAbsentKeysHaveNone) {
  EXPECT_FALSE(number_at(changed_number("alloy.card", "paper"), "alloy.card"));
  EXPECT_FALSE(
      number_at(changed_number("schedule.casting_speed", "[[0 s, 40 mm/min], [9 s, 60 mm/min]]"),
                "schedule.casting_speed"));
  const v1::Case empty;
  for (const char* const key :
       {"mesh.rows", "mesh.lines", "monitor[0].x", "monitor.x", "mesh", "x"})
    EXPECT_FALSE(number_at(empty, key)) << key;
}

TEST(KeyNumber, KnowsWholeNumbers) {
  const v1::Case empty;
  EXPECT_TRUE(is_whole_number(empty, "mesh.rows"));
  EXPECT_FALSE(is_whole_number(empty, "section.half_width"));
  EXPECT_FALSE(is_whole_number(empty, "mesh.lines"));
}

}  // namespace
}  // namespace dccast::case_file
