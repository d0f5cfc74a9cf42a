// A shipped case with a shipped alloy, of which some keys are taken away or changed, checked as a
// whole: no gap and no number ends the check, and each fault says what is wrong. Three bytes are a
// change: two choose the key, one what becomes of it.
#include <cmath>
#include <limits>
#include <utility>

#include <google/protobuf/descriptor.h>

#include "proto/case_file/shipped.hpp"
#include "tests/fuzz/whole_check.hpp"

using namespace dccast;
using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

namespace {

struct Start {
  v1::Case description;
  v1::Alloy card;
};

/// Each shipped case, with each shipped alloy.
const std::vector<Start>& starts() {
  static const std::vector<Start> all = [] {
    std::vector<Start> made;
    for (const auto& shipped : shipped::case_templates())
      for (const std::string& name : case_file::alloy_names()) {
        Start start{.description = {}, .card = case_file::alloy_card(name).alloy};
        case_file::read_text(shipped.text, shipped.name, start.description);
        start.description.mutable_alloy()->Clear();
        made.push_back(std::move(start));
      }
    return made;
  }();
  return all;
}

/// A key of a message, given or not.
struct Key {
  Message* table;
  const FieldDescriptor* field;
};

void add_keys(Message& table, std::vector<Key>& keys) {
  const auto& reflection = *table.GetReflection();
  for (int i = 0; i < table.GetDescriptor()->field_count(); ++i) {
    const FieldDescriptor* const field = table.GetDescriptor()->field(i);
    keys.push_back({&table, field});
    if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) continue;
    if (!field->is_repeated() && reflection.HasField(table, field))
      add_keys(*reflection.MutableMessage(&table, field), keys);
    for (int k = 0; field->is_repeated() && k < reflection.FieldSize(table, field); ++k)
      add_keys(*reflection.MutableRepeatedMessage(&table, field, k), keys);
  }
}

double changed(double value, unsigned how) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  switch (how % 10) {
    case 0:
      return 0.0;
    case 1:
      return -value;
    case 2:
      return 1e3 * value;
    case 3:
      return 1e-3 * value;
    case 4:
      return std::numeric_limits<double>::quiet_NaN();
    case 5:
      return infinity;
    case 6:
      return std::nextafter(value, infinity);
    case 7:
      return value + 1.0;
    case 8:
      return 0.5 * value;
    default:
      return 1.0;
  }
}

void change_list(Message& table, const FieldDescriptor& field, unsigned how) {
  const auto& reflection = *table.GetReflection();
  const int size = reflection.FieldSize(table, &field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE && how % 3 == 0)
    return reflection.AddDouble(&table, &field, changed(1.0, how / 3));
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && how % 3 == 0 && size < 20) {
    reflection.AddMessage(&table, &field);
    return;
  }
  if (size == 0) return;
  if (how % 3 == 1) return reflection.RemoveLast(&table, &field);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE) {
    const int at = static_cast<int>(how) % size;
    const double value = reflection.GetRepeatedDouble(table, &field, at);
    reflection.SetRepeatedDouble(&table, &field, at, changed(value, how / 3));
  }
}

void change(const Key& key, unsigned how) {
  Message& table = *key.table;
  const auto& reflection = *table.GetReflection();
  if (how % 4 == 0) return reflection.ClearField(&table, key.field);
  how /= 4;
  if (key.field->is_repeated()) return change_list(table, *key.field, how);

  switch (key.field->cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.SetDouble(&table, key.field,
                                  changed(reflection.GetDouble(table, key.field), how));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.SetBool(&table, key.field, !reflection.GetBool(table, key.field));
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.SetInt32(&table, key.field, static_cast<int>(how) - 3);
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection.SetInt64(&table, key.field, static_cast<int>(how) - 3);
    case FieldDescriptor::CPPTYPE_ENUM:
      return reflection.SetEnumValue(&table, key.field, static_cast<int>(how % 8));
    case FieldDescriptor::CPPTYPE_MESSAGE:
      reflection.MutableMessage(&table, key.field);
      return;
    default:
      return;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  constexpr std::size_t most_changes = 8;
  std::string_view text = fuzz::text_of(bytes, size);
  const unsigned first = fuzz::take_choice(text);
  Start start = starts()[first % starts().size()];

  for (std::size_t i = 0; i < most_changes && text.size() >= 3; ++i) {
    const unsigned place = fuzz::take_choice(text) + 256 * fuzz::take_choice(text);
    std::vector<Key> keys;
    // Half of the changes are of the card.
    if (place % 2 == 0)
      add_keys(start.card, keys);
    else
      add_keys(start.description, keys);
    change(keys[(place / 2) % keys.size()], fuzz::take_choice(text));
  }

  v1::ValidateCaseResponse verdict;
  fuzz::check_whole(start.card, "/nonexistent", start.description, verdict);
  for (const v1::Fault& fault : verdict.faults())
    fuzz::require(!fault.field().empty() && !fault.message().empty(), "a fault says what is wrong");
  return 0;
}
