#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <mutex>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// A quantity as in a file: a string with its unit, or a bare number for the unit "1".
std::string real_text(double value, const std::string& unit) {
  if (unit.empty() || unit == "1") return number_text(value);
  return quoted(quantity_text(value, unit));
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

  return curve_text(curve_of(message, field), key_of(field).unit());
}

using KeyValues = std::vector<std::pair<std::string, std::string>>;

/// The lines KEY = RANGE of a field.
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

/// Calls visit(table, path) for each table of a field.
template <typename Visit>
void for_each_table(const Message& message, const FieldDescriptor& field, const std::string& path,
                    const Visit& visit) {
  const Reflection& reflection = *message.GetReflection();
  if (!field.is_repeated()) return visit(reflection.GetMessage(message, &field), path);
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
    visit(reflection.GetRepeatedMessage(message, &field, i),
          element_path(path, static_cast<std::size_t>(i)));
}

/// Appends a table to the text: keys before tables, because a key after the header of a table
/// belongs to that table. Keys of the schema need no quotes.
void write_table(const Message& message, const std::string& path, std::string& text) {
  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor()))
    if (!is_table(*field) && is_present(message, *field))
      text += fmt::format("{} = {}\n", toml_key(*field), value_text(message, *field));

  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    if (!is_table(*field) || !is_present(message, *field)) continue;
    const std::string name = join_path(path, toml_key(*field));
    const bool list = field->is_repeated() && !is_ranges(*field);

    const std::string header =
        list ? fmt::format("\n[[{}]]\n", name) : fmt::format("\n[{}]\n", name);
    if (is_ranges(*field)) {
      text += header;
      for (const auto& [key, range] : range_lines(message, *field))
        text += fmt::format("{} = {}\n", quoted(key), quoted(range));
    } else {
      for_each_table(message, *field, name, [&](const Message& table, const std::string&) {
        text += header;
        write_table(table, name, text);
      });
    }
  }
}

/// Collects all keys below a path.
void collect(const Message& message, const std::string& path, KeyValues& values) {
  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    const std::string key = join_path(path, toml_key(*field));
    if (!is_present(message, *field)) continue;

    if (!is_table(*field))
      values.emplace_back(key, value_text(message, *field));
    else if (is_ranges(*field))
      for (const auto& [line, range] : range_lines(message, *field))
        values.emplace_back(join_path(key, line), quoted(range));
    else
      for_each_table(message, *field, key, [&](const Message& table, const std::string& place) {
        collect(table, place, values);
      });
  }
}

/// The type of a key in the reference.
std::string describe_type(const FieldDescriptor& field) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return "choice";
    case FieldDescriptor::CPPTYPE_BOOL:
      return "flag";
    case FieldDescriptor::CPPTYPE_STRING:
      return names_file(field, "name") ? "file" : "text";
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_INT64:
      return "integer";
    default:
      if (is_table(field)) return "table";
      return key_of(field).unit() == "1" ? "number" : "quantity";
  }
}

KeyReference describe_field(const FieldDescriptor& field, const std::string& path) {
  const v1::Key& key = key_of(field);
  const bool is_choice = field.cpp_type() == FieldDescriptor::CPPTYPE_ENUM;
  std::vector<std::string> against;
  for (const v1::Abscissa abscissa : abscissae_of(field))
    against.push_back(abscissa_name(abscissa));

  return {.path = path,
          .type = describe_type(field),
          .unit = key.unit(),
          .permitted = is_choice ? joined(enum_texts(field)) : range_text(field),
          .against = joined(against),
          .default_text = key.default_text(),
          .doc = key.doc(),
          .curve = is_curve(field),
          .required = key.required(),
          .size = size_text(field),
          .uncertainty = key.uncertainty()};
}

/// Appends the rows of a message and of its tables.
void append(const Descriptor& descriptor, const std::string& parent,
            std::vector<KeyReference>& rows) {
  for (const FieldDescriptor* const field : fields_of(descriptor)) {
    const bool list = field->is_repeated() && !is_ranges(*field);
    const std::string path = join_path(parent, toml_key(*field)) + (list ? "[]" : "");
    rows.push_back(describe_field(*field, path));
    if (is_table(*field) && !is_ranges(*field)) append(*field->message_type(), path, rows);
  }
}

}  // namespace

std::string curve_text(const v1::Curve& curve, const std::string& unit) {
  if (curve.at_size() == 1 && curve.abscissa() == v1::ABSCISSA_UNSPECIFIED)
    return real_text(curve.value(0), unit);

  std::vector<std::string> points;
  for (int i = 0; i < curve.at_size(); ++i)
    points.push_back(fmt::format("[{}, {}]",
                                 real_text(curve.at(i), abscissa_unit(curve.abscissa())),
                                 real_text(curve.value(i), unit)));
  return fmt::format("[{}]", fmt::join(points, ", "));
}

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

const std::vector<KeyReference>& reference(const Descriptor& descriptor) {
  static std::mutex mutex;
  static std::map<const Descriptor*, std::vector<KeyReference>> references;

  const std::lock_guard lock(mutex);
  const auto [known, is_new] = references.try_emplace(&descriptor);
  if (is_new) append(descriptor, "", known->second);
  return known->second;
}

}  // namespace dccast::case_file
