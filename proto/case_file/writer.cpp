#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/ranges.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// A number of a quantity: a string with unit, or bare for "1". TOML writes a real number with a
/// point or an exponent, but reads a whole one too.
std::string real_text(double value, const std::string& unit) {
  if (unit.empty() || unit == "1") return number_text(value);
  return quoted(quantity_text(value, unit));
}

std::string curve_text(const v1::Curve& curve, const std::string& unit) {
  if (curve.at_size() == 1 && curve.abscissa() == v1::ABSCISSA_UNSPECIFIED)
    return real_text(curve.value(0), unit);
  std::string text = "[";
  for (int i = 0; i < curve.at_size(); ++i)
    text += (i == 0 ? "[" : ", [") + real_text(curve.at(i), abscissa_unit(curve.abscissa())) +
            ", " + real_text(curve.value(i), unit) + "]";
  return text + "]";
}

std::string value_text(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return quoted(lower(reflection.GetEnum(message, &field)->name()));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.GetBool(message, &field) ? "true" : "false";
    case FieldDescriptor::CPPTYPE_STRING:
      return quoted(reflection.GetString(message, &field));
    case FieldDescriptor::CPPTYPE_INT32:
      return std::to_string(reflection.GetInt32(message, &field));
    case FieldDescriptor::CPPTYPE_INT64:
      return std::to_string(reflection.GetInt64(message, &field));
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return real_text(reflection.GetDouble(message, &field), key_of(field).unit());
    default:
      break;
  }
  v1::Curve curve;
  curve.ParseFromString(reflection.GetMessage(message, &field).SerializeAsString());
  return curve_text(curve, key_of(field).unit());
}

using KeyValues = std::vector<std::pair<std::string, std::string>>;

KeyValues range_lines(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  KeyValues lines;
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
    v1::KeyRange range;
    range.ParseFromString(reflection.GetRepeatedMessage(message, &field, i).SerializeAsString());
    lines.emplace_back(range.key(), range.range());
  }
  return lines;
}

/// "[a.b]" or "[[a.b]]"; keys of the schema are bare keys.
void write_table(const Message& message, const std::string& path, std::string& text);

void write_tables(const Message& message, const FieldDescriptor& field, const std::string& path,
                  std::string& text) {
  const Reflection& reflection = *message.GetReflection();
  if (is_ranges(field)) {
    text += "\n[" + path + "]\n";
    for (const auto& [key, range] : range_lines(message, field))
      text += quoted(key) + " = " + quoted(range) + "\n";
    return;
  }
  if (!field.is_repeated()) {
    text += "\n[" + path + "]\n";
    return write_table(reflection.GetMessage(message, &field), path, text);
  }
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i) {
    text += "\n[[" + path + "]]\n";
    write_table(reflection.GetRepeatedMessage(message, &field, i), path, text);
  }
}

/// Keys before tables: a key after a table's header would belong to that table.
void write_table(const Message& message, const std::string& path, std::string& text) {
  const Descriptor& descriptor = *message.GetDescriptor();
  for (const bool tables : {false, true})
    for (int i = 0; i < descriptor.field_count(); ++i) {
      const FieldDescriptor& field = *descriptor.field(i);
      if (is_table(field) != tables || !is_present(message, field)) continue;
      if (tables)
        write_tables(message, field, join_path(path, toml_key(field)), text);
      else
        text += toml_key(field) + " = " + value_text(message, field) + "\n";
    }
}

void collect(const Message& message, const std::string& path, KeyValues& values) {
  const Descriptor& descriptor = *message.GetDescriptor();
  const Reflection& reflection = *message.GetReflection();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    const std::string key = join_path(path, toml_key(field));
    if (!is_present(message, field)) continue;
    if (!is_table(field))
      values.emplace_back(key, value_text(message, field));
    else if (is_ranges(field))
      for (const auto& [line, range] : range_lines(message, field))
        values.emplace_back(join_path(key, line), quoted(range));
    else if (!field.is_repeated())
      collect(reflection.GetMessage(message, &field), key, values);
    else
      for (int j = 0; j < reflection.FieldSize(message, &field); ++j)
        collect(reflection.GetRepeatedMessage(message, &field, j),
                key + "[" + std::to_string(j) + "]", values);
  }
}

}  // namespace

KeyValues key_values(const Message& message) {
  KeyValues values;
  collect(message, "", values);
  return values;
}

std::string to_toml(const Message& message) {
  std::string text;
  write_table(message, "", text);
  return text;
}

namespace {

std::string type_of(const FieldDescriptor& field) {
  if (is_table(field)) return "table";
  if (is_curve(field)) return key_of(field).unit() == "1" ? "number" : "quantity";
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return "choice";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "flag";
    case FieldDescriptor::CPPTYPE_STRING:
      return key_of(field).attachment() ? "file" : "text";
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return key_of(field).unit() == "1" ? "number" : "quantity";
    default:
      return "integer";
  }
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

KeyReference describe_field(const FieldDescriptor& field, const std::string& path) {
  const v1::Key& key = key_of(field);
  KeyReference row{path,
                   type_of(field),
                   key.unit(),
                   range_text(field),
                   "",
                   key.default_text(),
                   key.doc(),
                   is_curve(field),
                   key.required(),
                   "",
                   key.uncertainty()};
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM) row.permitted = joined(enum_texts(field));
  std::vector<std::string> against;
  for (const v1::Abscissa abscissa : abscissae_of(field))
    against.push_back(abscissa_name(abscissa));
  row.against = joined(against);
  row.size = size_text(field);
  return row;
}

void append(const Descriptor& descriptor, const std::string& parent,
            std::vector<KeyReference>& rows) {
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    const bool list = field.is_repeated() && !is_ranges(field);
    const std::string path = join_path(parent, toml_key(field)) + (list ? "[]" : "");
    rows.push_back(describe_field(field, path));
    if (is_table(field) && !is_ranges(field)) append(*field.message_type(), path, rows);
  }
}

}  // namespace

std::vector<KeyReference> reference(const Descriptor& descriptor) {
  std::vector<KeyReference> rows;
  append(descriptor, "", rows);
  return rows;
}

}  // namespace dccast::case_file
