#include "proto/case_file/schema.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/quantity.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

bool is_message_of(const FieldDescriptor& field, const Descriptor& descriptor) {
  if (field.cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) return false;
  // Of another descriptor pool (dynamic messages) the name alone is the same.
  return field.message_type() == &descriptor ||
         field.message_type()->full_name() == descriptor.full_name();
}

/// toml_key() without a copy.
std::string_view key_in_name(const FieldDescriptor& field) {
  const auto suffix = unit_suffix(key_of(field).unit());
  if (!suffix || !field.name().ends_with(*suffix))
    throw std::logic_error(
        fmt::format("field {} does not end in the suffix of its unit", field.full_name()));
  return std::string_view(field.name()).substr(0, field.name().size() - suffix->size());
}

/// The bounds of a key in a unit: "0 to 0.1 m/s", "more than 0 Pa, at most 1 Pa".
std::string bounds_text(const v1::Key& key, const std::string& unit) {
  const auto bound = [&](double value) {
    if (unit != key.unit()) value = convert(value, key.unit(), unit).value_or(value);
    return fmt::format("{:.6g}", value);  // rounded: for reading only
  };

  std::vector<std::string> bounds;
  if (key.has_minimum() && key.has_maximum() && !key.minimum_excluded() &&
      !key.maximum_excluded()) {
    bounds.push_back(fmt::format("{} to {}", bound(key.minimum()), bound(key.maximum())));
  } else {
    if (key.has_minimum())
      bounds.push_back(fmt::format("{} {}", key.minimum_excluded() ? "more than" : "at least",
                                   bound(key.minimum())));
    if (key.has_maximum())
      bounds.push_back(fmt::format("{} {}", key.maximum_excluded() ? "less than" : "at most",
                                   bound(key.maximum())));
  }

  const bool has_unit = !bounds.empty() && !unit.empty() && unit != "1";
  return has_unit ? fmt::format("{} {}", joined(bounds), unit) : joined(bounds);
}

bool in_range(const v1::Key& key, double value) {
  if (key.has_minimum() &&
      (value < key.minimum() || (key.minimum_excluded() && value == key.minimum())))
    return false;
  return !(key.has_maximum() &&
           (value > key.maximum() || (key.maximum_excluded() && value == key.maximum())));
}

/// A long text such as a description may have several lines; a title or a name appears in lists
/// and logs.
values::Lines permitted_lines(const FieldDescriptor& field) {
  constexpr int longest_line = 255;
  return key_of(field).maximum_length() > longest_line ? values::Lines::several
                                                       : values::Lines::one;
}

/// Largest length of a text [bytes].
std::size_t maximum_length(const FieldDescriptor& field) {
  const int stated = key_of(field).maximum_length();
  return stated > 0 ? static_cast<std::size_t>(stated) : 1000;
}

/// Largest number of entries of a table or points of a curve.
std::size_t maximum_count(const FieldDescriptor& field) {
  const int stated = key_of(field).maximum_count();
  return stated > 0 ? static_cast<std::size_t>(stated) : 10000;
}

}  // namespace

const v1::Key& key_of(const FieldDescriptor& field) {
  return field.options().GetExtension(v1::key);
}

std::string toml_key(const FieldDescriptor& field) {
  return std::string(key_in_name(field));
}

std::vector<const FieldDescriptor*> fields_of(const Descriptor& descriptor) {
  std::vector<const FieldDescriptor*> fields;
  for (int i = 0; i < descriptor.field_count(); ++i) fields.push_back(descriptor.field(i));
  return fields;
}

const FieldDescriptor* field_of_key(const Descriptor& descriptor, std::string_view key) {
  for (int i = 0; i < descriptor.field_count(); ++i)
    if (key_in_name(*descriptor.field(i)) == key) return descriptor.field(i);
  return nullptr;
}

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

const google::protobuf::EnumValueDescriptor* enum_value_of(const FieldDescriptor& field,
                                                           std::string_view text) {
  const auto& type = *field.enum_type();
  for (int i = 0; i < type.value_count(); ++i)
    if (type.value(i)->number() != 0 && lower(type.value(i)->name()) == text) return type.value(i);
  return nullptr;
}

std::vector<std::string> enum_texts(const FieldDescriptor& field) {
  std::vector<std::string> texts;
  for (int i = 0; i < field.enum_type()->value_count(); ++i)
    if (field.enum_type()->value(i)->number() != 0)
      texts.push_back(lower(field.enum_type()->value(i)->name()));
  return texts;
}

bool is_curve(const FieldDescriptor& field) {
  return is_message_of(field, *v1::Curve::descriptor());
}

bool is_alloy(const FieldDescriptor& field) {
  return is_message_of(field, *v1::Alloy::descriptor());
}

bool is_ranges(const FieldDescriptor& field) {
  return is_message_of(field, *v1::KeyRange::descriptor());
}

bool is_table(const FieldDescriptor& field) {
  return field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE && !is_curve(field);
}

bool names_file(const FieldDescriptor& field, std::string_view value) {
  const v1::Key& key = key_of(field);
  return key.attachment() && !value.empty() && value.ends_with(key.attachment_suffix());
}

bool is_present(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  if (field.is_repeated()) return reflection.FieldSize(message, &field) > 0;
  return reflection.HasField(message, &field);
}

std::optional<double> number_of(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  if (field.is_repeated() || !is_present(message, field)) return std::nullopt;

  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_INT64:
      return static_cast<double>(reflection.GetInt64(message, &field));
    default:
      return std::nullopt;
  }
}

v1::Curve curve_of(const Message& message, const FieldDescriptor& field) {
  const Message& table = message.GetReflection()->GetMessage(message, &field);
  if (const auto* const generated = dynamic_cast<const v1::Curve*>(&table)) return *generated;

  v1::Curve curve;  // of another descriptor pool (dynamic messages)
  curve.ParseFromString(table.SerializeAsString());
  return curve;
}

std::string abscissa_unit(v1::Abscissa abscissa) {
  switch (abscissa) {
    case v1::TIME:
      return "s";
    case v1::CAST_LENGTH:
    case v1::GAP:
    case v1::DISTANCE:
      return "m";
    case v1::TEMPERATURE:
      return "degC";
    case v1::LIQUID_FRACTION:
      return "1";
    default:
      return "";
  }
}

std::string abscissa_name(v1::Abscissa abscissa) {
  std::string name = lower(v1::Abscissa_Name(abscissa));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::vector<v1::Abscissa> abscissae_of(const FieldDescriptor& field) {
  std::vector<v1::Abscissa> abscissae;
  for (const int number : key_of(field).against())
    abscissae.push_back(static_cast<v1::Abscissa>(number));
  return abscissae;
}

std::string join_path(const std::string& parent, const std::string& key) {
  return parent.empty() ? key : parent + '.' + key;
}

std::string element_path(const std::string& list, std::size_t element) {
  return list + '[' + std::to_string(element) + ']';
}

std::string joined(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

std::string range_text(const FieldDescriptor& field, const std::string& other_unit) {
  const v1::Key& key = key_of(field);
  std::string text = bounds_text(key, key.unit());
  const bool translate = !other_unit.empty() && other_unit != key.unit() && key.unit() != "1";
  if (text.empty() || !translate || !convertible(other_unit, key.unit())) return text;
  return fmt::format("{} ({})", text, bounds_text(key, other_unit));
}

std::optional<v1::Fault> range_fault(const FieldDescriptor& field, double value,
                                     const std::string& path, const std::string& written,
                                     const std::string& unit_written) {
  if (!std::isfinite(value))
    return make_fault(path, written, "not a finite number", range_text(field, unit_written));
  if (in_range(key_of(field), value)) return std::nullopt;
  return make_fault(path, written, "out of range", range_text(field, unit_written));
}

std::string size_text(const FieldDescriptor& field) {
  if (is_curve(field)) return fmt::format("at most {} points", maximum_count(field));
  if (field.is_repeated()) return fmt::format("at most {} entries", maximum_count(field));
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
    return fmt::format("at most {} bytes", maximum_length(field));
  return {};
}

std::optional<v1::Fault> text_fault(const FieldDescriptor& field, const std::string& text,
                                    const std::string& path) {
  if (text.size() > maximum_length(field))
    return make_fault(path, quoted(values::shortened(text, maximum_length(field))),
                      fmt::format("a text of {} bytes", text.size()), size_text(field),
                      key_of(field).attachment() ? "rename the file" : "shorten it");

  const auto character = values::unprintable(text, permitted_lines(field));
  if (!character) return std::nullopt;
  return make_fault(path, quoted(values::shown(text)), fmt::format("contains {}", *character),
                    "printable characters", "remove this character");
}

std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path) {
  if (count <= maximum_count(field)) return std::nullopt;
  const bool curve = is_curve(field);
  return make_fault(path, "", fmt::format("{} {}", count, curve ? "points" : "entries"),
                    size_text(field),
                    curve ? "thin the table out; it is interpolated linearly between points"
                          : "leave some of them out");
}

v1::Fault missing_fault(const FieldDescriptor& field, const std::string& path) {
  return make_fault(path, "", "required key is missing", range_text(field),
                    fmt::format("e.g. {} = {}", toml_key(field), example_text(field)));
}

v1::Fault make_fault(std::string path, const std::string& value, std::string message,
                     std::string permitted, std::string remedy) {
  v1::Fault fault;
  fault.set_field(std::move(path));
  fault.set_value(values::shortened(value));
  fault.set_message(std::move(message));
  fault.set_permitted(std::move(permitted));
  fault.set_remedy(std::move(remedy));
  return fault;
}

std::string example_text(const FieldDescriptor& field) {
  const v1::Key& key = key_of(field);
  const std::string& standard = key.default_text();
  if (!standard.empty() && !standard.starts_with('[') && standard != by_quality &&
      standard != "\"\"")
    return standard;

  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return fmt::format("\"{}\"", enum_texts(field).front());
    case FieldDescriptor::CPPTYPE_BOOL:
      return "true";
    case FieldDescriptor::CPPTYPE_STRING:
      return "\"text\"";
    default:
      break;
  }

  // Numbers in the units that plants use.
  if (key.unit().empty()) return number_text(std::max(1.0, key.minimum()));
  if (key.unit() == "1") return number_text(std::max(0.3, key.minimum()));
  if (key.unit() == "degC") return "\"650 degC\"";
  if (key.unit() == "m/s") return "\"60 mm/min\"";
  if (key.unit() == "m") return "\"30 mm\"";
  if (key.unit() == "m2/s") return "\"180 l/min/m\"";
  return quoted(quantity_text(std::max(1.0, key.minimum()), key.unit()));
}

}  // namespace dccast::case_file
