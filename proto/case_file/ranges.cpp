#include "proto/case_file/ranges.hpp"

#include <cmath>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

/// A description may have lines; a title or a name stands in lists and logs.
values::Lines lines_of(const FieldDescriptor& field) {
  constexpr int longest_line = 255;
  return key_of(field).maximum_length() > longest_line ? values::Lines::several
                                                       : values::Lines::one;
}

std::size_t stated_or(std::int32_t stated, std::size_t general) {
  return stated > 0 ? static_cast<std::size_t>(stated) : general;
}

}  // namespace

std::size_t maximum_length(const FieldDescriptor& field) {
  return stated_or(key_of(field).maximum_length(), general_maximum_length);
}

std::size_t maximum_count(const FieldDescriptor& field) {
  return stated_or(key_of(field).maximum_count(), general_maximum_count);
}

std::string size_text(const FieldDescriptor& field) {
  const auto at_most = [](std::size_t number, const char* of) {
    return "at most " + std::to_string(number) + of;
  };
  if (is_curve(field)) return at_most(maximum_count(field), " points");
  if (field.is_repeated()) return at_most(maximum_count(field), " entries");
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
    return at_most(maximum_length(field), " bytes");
  return {};
}

std::optional<v1::Fault> text_fault(const FieldDescriptor& field, const std::string& text,
                                    const std::string& path) {
  if (text.size() > maximum_length(field))
    return make_fault(path, quoted(values::shortened(text, maximum_length(field))),
                      "a text of " + std::to_string(text.size()) + " bytes", size_text(field),
                      key_of(field).attachment() ? "rename the file" : "shorten it");
  const auto character = values::unprintable(text, lines_of(field));
  if (!character) return std::nullopt;
  return make_fault(path, quoted(values::escaped(values::shortened(text))),
                    "contains " + *character, "characters that can be shown",
                    "leave that character out");
}

std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path) {
  if (count <= maximum_count(field)) return std::nullopt;
  const bool curve = is_curve(field);
  return make_fault(path, "", std::to_string(count) + (curve ? " points" : " entries"),
                    size_text(field),
                    curve ? "thin the table out; it is interpolated linearly between points"
                          : "leave some of them out");
}

namespace {

using Faults = std::vector<v1::Fault>;

void check_message(const Message& message, const std::string& path, Faults& faults);

void check_curve_values(const v1::Curve& curve, const FieldDescriptor& field,
                        const std::string& path, Faults& faults) {
  for (int i = 0; i < curve.value_size(); ++i) {
    const std::string written = quantity_text(curve.value(i), key_of(field).unit());
    if (auto fault =
            range_fault(field, curve.value(i), path + "[" + std::to_string(i) + "]", written, ""))
      faults.push_back(std::move(*fault));
  }
}

void check_abscissa_kind(const v1::Curve& curve, const FieldDescriptor& field,
                         const std::string& path, Faults& faults) {
  const auto permitted = abscissae_of(field);
  if (std::find(permitted.begin(), permitted.end(), curve.abscissa()) == permitted.end())
    faults.push_back(make_fault(path, abscissa_name(curve.abscissa()),
                                "not a permitted abscissa of this table"));
}

void check_curve_abscissae(const v1::Curve& curve, const std::string& path, Faults& faults) {
  for (int i = 0; i < curve.at_size(); ++i) {
    const std::string point = path + "[" + std::to_string(i) + "]";
    if (!std::isfinite(curve.at(i)))
      faults.push_back(make_fault(point, number_text(curve.at(i)), "not a finite number"));
    else if (i > 0 && !(curve.at(i) > curve.at(i - 1)))
      faults.push_back(
          make_fault(point, quantity_text(curve.at(i), abscissa_unit(curve.abscissa())),
                     "must be larger than that of the point before it", "strictly increasing"));
  }
}

void check_curve(const v1::Curve& curve, const FieldDescriptor& field, const std::string& path,
                 Faults& faults) {
  if (curve.value_size() == 0 && curve.at_size() == 0)
    return faults.push_back(make_fault(path, "", "an empty table", "at least one point"));
  if (curve.value_size() != curve.at_size())
    return faults.push_back(make_fault(path,
                                       std::to_string(curve.at_size()) + " abscissae, " +
                                           std::to_string(curve.value_size()) + " values",
                                       "as many values as abscissae are needed"));
  if (auto fault = count_fault(field, static_cast<std::size_t>(curve.at_size()), path))
    return faults.push_back(std::move(*fault));
  check_curve_values(curve, field, path, faults);
  // One point is a constant, which stands against nothing.
  if (curve.at_size() > 1) check_abscissa_kind(curve, field, path, faults);
  check_curve_abscissae(curve, path, faults);
}

void check_enum(const Message& message, const FieldDescriptor& field, const std::string& path,
                Faults& faults) {
  const int number = message.GetReflection()->GetEnumValue(message, &field);
  if (field.enum_type()->FindValueByNumber(number) == nullptr)
    faults.push_back(make_fault(path, std::to_string(number), "unknown choice"));
}

void check_text(const Message& message, const FieldDescriptor& field, const std::string& path,
                Faults& faults) {
  const std::string text = message.GetReflection()->GetString(message, &field);
  if (auto fault = text_fault(field, text, path)) faults.push_back(std::move(*fault));
}

void check_scalar(const Message& message, const FieldDescriptor& field, const std::string& path,
                  Faults& faults) {
  const Reflection& reflection = *message.GetReflection();
  double number = 0.0;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return check_enum(message, field, path, faults);
    case FieldDescriptor::CPPTYPE_STRING:
      return check_text(message, field, path, faults);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      number = reflection.GetDouble(message, &field);
      break;
    case FieldDescriptor::CPPTYPE_INT32:
      number = reflection.GetInt32(message, &field);
      break;
    case FieldDescriptor::CPPTYPE_INT64:
      number = static_cast<double>(reflection.GetInt64(message, &field));
      break;
    default:
      return;
  }
  if (auto fault =
          range_fault(field, number, path, quantity_text(number, key_of(field).unit()), ""))
    faults.push_back(std::move(*fault));
}

void check_tables(const Message& message, const FieldDescriptor& field, const std::string& path,
                  Faults& faults) {
  const Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated())
    return check_message(reflection.GetMessage(message, &field), path, faults);
  const int count = reflection.FieldSize(message, &field);
  if (auto fault = count_fault(field, static_cast<std::size_t>(count), path))
    return faults.push_back(std::move(*fault));
  for (int i = 0; i < count; ++i)
    check_message(reflection.GetRepeatedMessage(message, &field, i),
                  path + "[" + std::to_string(i) + "]", faults);
}

/// Whether the key that may stand in for a required one is given.
bool stands_in(const Message& message, const std::string& key) {
  const Descriptor& descriptor = *message.GetDescriptor();
  for (int i = 0; !key.empty() && i < descriptor.field_count(); ++i)
    if (toml_key(*descriptor.field(i)) == key && is_present(message, *descriptor.field(i)))
      return true;
  return false;
}

void check_field(const Message& message, const FieldDescriptor& field, const std::string& path,
                 Faults& faults) {
  if (is_table(field)) return check_tables(message, field, path, faults);
  if (!is_present(message, field)) {
    if (key_of(field).required() && !stands_in(message, key_of(field).unless()))
      faults.push_back(make_fault(path, "", "required key is missing", range_text(field),
                                  "e.g. " + toml_key(field) + " = " + example_text(field)));
    return;
  }
  if (!is_curve(field)) return check_scalar(message, field, path, faults);
  // A copy, so that a Curve of a foreign pool (dynamic messages) is read as well as ours.
  v1::Curve curve;
  curve.ParseFromString(message.GetReflection()->GetMessage(message, &field).SerializeAsString());
  check_curve(curve, field, path, faults);
}

void check_message(const Message& message, const std::string& path, Faults& faults) {
  const Descriptor& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i)
    check_field(message, *descriptor.field(i), join_path(path, toml_key(*descriptor.field(i))),
                faults);
}

/// The depth of the metal and the place of the block are one thing given in two ways.
void check_depth(const v1::Case& c, Faults& faults) {
  constexpr double same = 1e-9;  // [m]
  const v1::Section& section = c.section();
  if (section.has_initial_depth_m() && section.has_block_above_water_m() &&
      std::abs(section.initial_depth_m() + section.block_above_water_m() -
               c.cooling().water().from_m()) > same)
    faults.push_back(make_fault(
        "section.block_above_water", quantity_text(section.block_above_water_m(), "m"),
        "does not agree with section.initial_depth and cooling.water.from", "one of the two keys",
        "give section.initial_depth, or section.block_above_water"));
}

}  // namespace

std::vector<v1::Fault> check_ranges(const Message& message) {
  Faults faults;
  check_message(message, "", faults);
  if (const auto* c = dynamic_cast<const v1::Case*>(&message)) check_depth(*c, faults);
  return faults;
}

}  // namespace dccast::case_file
