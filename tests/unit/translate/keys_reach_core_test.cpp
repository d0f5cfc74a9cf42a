// Every key of a case acts on core, or stands below with its reason.
#include <google/protobuf/descriptor.h>
#include <google/protobuf/util/message_differencer.h>
#include <gtest/gtest.h>

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "proto/case_file/alloy_cards.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/shipped.hpp"
#include "server/translate/translate.hpp"
#include "tests/unit/translate/described.hpp"

namespace dccast::translate {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// Keys that core does not need, and why.
const std::map<std::string, std::string> not_of_core{
    {"alloy.description", "for people"},
    {"alloy.provenance", "for people"},
    {"alloy.uncertainty[0].key", "studies vary the key that it names"},
    {"alloy.uncertainty[0].range", "studies vary the key within it"},
    {"uncertainty[0].key", "studies vary the key that it names"},
    {"uncertainty[0].range", "studies vary the key within it"},
};

/// Keys that act by other keys, which they fill in before a case is translated.
const std::map<std::string, std::string> by_other_keys{
    {"quality", "picks mesh and time steps"},
    {"section.block_above_water", "gives section.initial_depth"},
};

/// A key: the fields that lead to it. Of a repeated table its first entry is meant.
using KeyPath = std::vector<const FieldDescriptor*>;

std::string name_of(const KeyPath& path) {
  std::string name;
  for (const FieldDescriptor* field : path) {
    name += (name.empty() ? "" : ".") + case_file::toml_key(*field);
    if (case_file::is_table(*field) && field->is_repeated()) name += "[0]";
  }
  return name;
}

/// Adds the keys of a table and of those within it.
void add_keys(const google::protobuf::Descriptor& table, const KeyPath& above,
              std::vector<KeyPath>& keys) {
  for (int i = 0; i < table.field_count(); ++i) {
    KeyPath path = above;
    path.push_back(table.field(i));
    if (case_file::is_table(*path.back()))
      add_keys(*path.back()->message_type(), path, keys);
    else
      keys.push_back(path);
  }
}

/// The table that has a key; tables on the way to it are made.
Message& table_of(const KeyPath& path, v1::Case& description) {
  Message* table = &description;
  for (std::size_t i = 0; i + 1 < path.size(); ++i) {
    const Reflection& reflection = *table->GetReflection();
    if (!path[i]->is_repeated())
      table = reflection.MutableMessage(table, path[i]);
    else if (reflection.FieldSize(*table, path[i]) == 0)
      table = reflection.AddMessage(table, path[i]);
    else
      table = reflection.MutableRepeatedMessage(table, path[i], 0);
  }
  return *table;
}

/// Another number within the range of a key.
double moved(const v1::Key& key, double from) {
  if (!key.has_maximum()) return std::max(from, key.minimum()) + 1.0;
  const double low = key.has_minimum() ? key.minimum() : key.maximum() - 2.0;
  const double middle = 0.5 * (low + key.maximum());
  return from == middle ? 0.5 * (middle + key.maximum()) : middle;
}

/// Values of a key other than its own, one after the other.
void move_key(Message& table, const FieldDescriptor& field, int choice) {
  const Reflection& reflection = *table.GetReflection();
  const v1::Key& key = case_file::key_of(field);
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.SetBool(&table, &field, !reflection.GetBool(table, &field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.SetDouble(&table, &field, moved(key, reflection.GetDouble(table, &field)));
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.SetInt32(&table, &field,
                                 int(moved(key, reflection.GetInt32(table, &field))));
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection.SetInt64(
          &table, &field, std::int64_t(moved(key, double(reflection.GetInt64(table, &field)))));
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection.SetEnumValue(&table, &field, choice);
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection.SetString(&table, &field, choice == 1 ? "aa6063" : "aa5182");
    default:
      break;
  }

  auto& curve = dynamic_cast<v1::Curve&>(*reflection.MutableMessage(&table, &field));
  const double value = moved(key, curve.value_size() > 0 ? curve.value(0) : 0.0);
  curve.Clear();
  curve.add_at(0.0);
  curve.add_value(value);
}

/// How many values move_key() has for a key.
int choices(const FieldDescriptor& field) {
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM)
    return field.enum_type()->value_count() - 1;
  return field.cpp_type() == FieldDescriptor::CPPTYPE_STRING ? 2 : 1;
}

v1::Case completed(v1::Case description) {
  case_file::apply_defaults(description);
  const auto card = case_file::alloy_card(description.alloy().card());
  case_file::complete_alloy(card.alloy, *description.mutable_alloy());
  return description;
}

/// What core gets of a case, without the text of the case and what is computed beside it.
std::string of_core(const v1::Case& complete) {
  casting::Case to = to_core(complete, {});
  to.source_json.clear();
  to.relative_curl_error.reset();
  to.figure_errors.clear();
  return testing::Description().add(to).text();
}

/// The shipped cases: sections, billets and quarter slabs, of all kinds of alloys.
std::vector<v1::Case> shipped_cases() {
  std::vector<v1::Case> cases;
  for (const auto& text : shipped::case_templates()) {
    v1::Case description;
    EXPECT_TRUE(case_file::read_text(text.text, text.name, description).ok()) << text.name;
    cases.push_back(std::move(description));
  }
  return cases;
}

/// When a key is moved.
enum class Moved { before_completion, after_completion };

/// Whether core's case differs once a key is moved, in one of the cases.
bool reaches_core(const KeyPath& path, const std::vector<v1::Case>& cases, Moved when) {
  for (v1::Case description : cases) {
    table_of(path, description);
    const v1::Case complete = completed(description);
    const std::string before = of_core(complete);

    for (int choice = 1; choice <= choices(*path.back()); ++choice) {
      v1::Case changed = when == Moved::after_completion ? complete : description;
      move_key(table_of(path, changed), *path.back(), choice);
      if (when == Moved::before_completion) changed = completed(changed);

      if (!by_other_keys.contains(name_of(path))) {
        for (const v1::Fault& fault : case_file::check_ranges(changed))
          EXPECT_NE(fault.field(), name_of(path)) << fault.value() << ": " << fault.message();
      }
      if (of_core(changed) != before) return true;
    }
  }
  return false;
}

TEST(KeysOfACase, ReachCore) {
  const std::vector<v1::Case> cases = shipped_cases();
  std::vector<KeyPath> keys;
  add_keys(*v1::Case::descriptor(), {}, keys);
  EXPECT_GT(keys.size(), 200u);

  std::size_t listed = 0;
  for (const KeyPath& path : keys) {
    const std::string name = name_of(path);
    const bool fills_others = by_other_keys.contains(name);
    const bool stays_outside = not_of_core.contains(name);
    listed += fills_others || stays_outside;
    EXPECT_EQ(reaches_core(path, cases, Moved::after_completion), !fills_others && !stays_outside)
        << name;
    if (fills_others) {
      EXPECT_TRUE(reaches_core(path, cases, Moved::before_completion)) << name;
    }
  }
  EXPECT_EQ(listed, not_of_core.size() + by_other_keys.size()) << "each listed key is one";
}

}  // namespace
}  // namespace dccast::translate
