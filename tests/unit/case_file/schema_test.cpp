#include "proto/case_file/schema.hpp"

#include <set>

#include <gtest/gtest.h>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"

namespace dccast::case_file {
namespace {

/// Every field below a message, nested ones too.
void collect(const Descriptor& descriptor, std::vector<const FieldDescriptor*>& fields) {
  for (int i = 0; i < descriptor.field_count(); ++i) {
    fields.push_back(descriptor.field(i));
    if (is_table(*descriptor.field(i))) collect(*descriptor.field(i)->message_type(), fields);
  }
}

std::vector<const FieldDescriptor*> schema_fields() {
  std::vector<const FieldDescriptor*> fields;
  collect(*v1::Case::descriptor(), fields);
  collect(*v1::DaemonConfig::descriptor(), fields);
  return fields;
}

TEST(Schema, EveryFieldWithUnitEndsInItsSuffix) {
  for (const FieldDescriptor* field : schema_fields()) {
    const auto suffix = unit_suffix(key_of(*field).unit());
    ASSERT_TRUE(suffix) << field->full_name() << " has unit " << key_of(*field).unit();
    EXPECT_TRUE(field->name().ends_with(*suffix)) << field->full_name() << " lacks " << *suffix;
  }
}

TEST(Schema, EveryFieldIsDocumentedAndItsUnitIsKnown) {
  for (const FieldDescriptor* field : schema_fields()) {
    EXPECT_FALSE(key_of(*field).doc().empty()) << field->full_name();
    const std::string& unit = key_of(*field).unit();
    EXPECT_TRUE(unit.empty() || unit == "1" || convertible(unit, unit)) << field->full_name();
  }
}

TEST(Schema, KeysOfATableDiffer) {
  for (const KeyReference& row : reference(*v1::Case::descriptor()))
    EXPECT_TRUE(row.type != "table" || row.unit.empty()) << row.path;
  std::set<std::string> paths;
  for (const KeyReference& row : reference(*v1::Case::descriptor()))
    EXPECT_TRUE(paths.insert(row.path).second) << row.path;
}

TEST(Schema, TheUnitOfAnAbscissaTellsWhichIsMeant) {
  for (const FieldDescriptor* field : schema_fields()) {
    if (!is_curve(*field)) continue;
    std::set<std::string> units;
    EXPECT_FALSE(abscissae_of(*field).empty()) << field->full_name();
    for (const v1::Abscissa abscissa : abscissae_of(*field))
      EXPECT_TRUE(units.insert(abscissa_unit(abscissa)).second) << field->full_name();
  }
}

TEST(Schema, KeyIsTheNameWithoutTheUnit) {
  const auto* field = v1::Schedule::descriptor()->FindFieldByName("casting_speed_m_per_s");
  EXPECT_EQ(toml_key(*field), "casting_speed");
  EXPECT_EQ(field_of_key(*v1::Schedule::descriptor(), "casting_speed"), field);
}

TEST(Schema, RangeIsAlsoSaidInTheUnitOfTheUser) {
  const auto* field = v1::Schedule::descriptor()->FindFieldByName("casting_speed_m_per_s");
  EXPECT_EQ(range_text(*field, "mm/min"), "0 to 0.1 m/s (0 to 6000 mm/min)");
}

}  // namespace
}  // namespace dccast::case_file
