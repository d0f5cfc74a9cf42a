#include "proto/case_file/toml_walker.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include "proto/case_file/quantity.hpp"
#include "proto/case_file/ranges.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

constexpr std::size_t maximum_faults = 500;
constexpr std::size_t longest_path_echo = 300;
constexpr std::uintmax_t maximum_attachment_bytes = std::uintmax_t{1} << 30;

std::vector<std::string> keys_of(const Descriptor& descriptor) {
  std::vector<std::string> keys;
  for (int i = 0; i < descriptor.field_count(); ++i) keys.push_back(toml_key(*descriptor.field(i)));
  return keys;
}

void add_wrong_type(Walk& walk, const toml::node& node, const FieldDescriptor& field,
                    const std::string& path, const std::string& expected) {
  walk.add(make_fault(path, written(node), type_name(node) + " where " + expected + " is expected",
                      range_text(field), "e.g. " + toml_key(field) + " = " + example_text(field)),
           node);
}

void read_enum(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
               const std::string& path) {
  std::string choices;
  for (const std::string& text : enum_texts(field)) choices += (choices.empty() ? "" : ", ") + text;
  const auto text = node.value<std::string>();
  if (!text) return add_wrong_type(walk, node, field, path, "one of the words " + choices);
  if (const auto* value = enum_value_of(field, *text))
    return message.GetReflection()->SetEnum(&message, &field, value);
  const std::string near = nearest(*text, enum_texts(field));
  walk.add(make_fault(path, written(node), "unknown choice", choices,
                      near.empty() ? "" : "did you mean \"" + near + "\"?"),
           node);
}

void read_integer(Walk& walk, const toml::node& node, const FieldDescriptor& field,
                  Message& message, const std::string& path) {
  if (!node.is_integer()) return add_wrong_type(walk, node, field, path, "a whole number");
  const std::int64_t number = node.as_integer()->get();
  if (auto fault = range_fault(field, static_cast<double>(number), path, written(node), ""))
    return walk.add(std::move(*fault), node);
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_INT64)
    return message.GetReflection()->SetInt64(&message, &field, number);
  if (number < std::numeric_limits<std::int32_t>::min() ||
      number > std::numeric_limits<std::int32_t>::max())
    return walk.add(make_fault(path, written(node), "out of range", range_text(field)), node);
  message.GetReflection()->SetInt32(&message, &field, static_cast<std::int32_t>(number));
}

/// Of a file that stands elsewhere. Returns its base name.
std::optional<std::string> list_file(Walk& walk, const toml::node& node, const std::string& name,
                                     const std::string& path) {
  const auto base_of = [](const std::string& file) {
    return std::filesystem::path(file).filename().string();
  };
  std::vector<std::string>& files = walk.outcome.files;
  for (const std::string& other : files)
    if (other != name && base_of(other) == base_of(name)) {
      walk.add(make_fault(path, written(node), "another attachment is also called " + base_of(name),
                          "files of different names"),
               node);
      return std::nullopt;
    }
  if (std::find(files.begin(), files.end(), name) == files.end()) files.push_back(name);
  return base_of(name);
}

/// Reads the file that `name` points to into the attachments; returns its base name.
std::optional<std::string> attach(Walk& walk, const toml::node& node, const std::string& name,
                                  const std::string& path) {
  if (walk.folder == nullptr) return list_file(walk, node, name, path);
  const std::filesystem::path file = *walk.folder / name;
  std::error_code error;
  const auto refuse = [&](const std::string& why) {
    walk.add(make_fault(path, written(node), values::shortened(why, longest_path_echo),
                        "a readable file, relative to the folder of the case file"),
             node);
    return std::nullopt;
  };
  if (!std::filesystem::exists(file, error)) return refuse("no such file: " + file.string());
  if (!std::filesystem::is_regular_file(file, error)) return refuse("not a file: " + file.string());
  if (std::filesystem::file_size(file, error) > maximum_attachment_bytes)
    return refuse("larger than 1 GiB: " + file.string());
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream content;
  if (!(stream && content << stream.rdbuf()) && std::filesystem::file_size(file, error) > 0)
    return refuse("cannot be read: " + file.string());
  const std::string base = file.filename().string();
  for (const v1::Attachment& other : walk.outcome.attachments)
    if (other.name() == base && other.content() != content.str())
      return refuse("another attachment is also called " + base);
  v1::Attachment attachment;
  attachment.set_name(base);
  attachment.set_content(content.str());
  walk.outcome.attachments.push_back(std::move(attachment));
  return base;
}

void read_string(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                 const std::string& path) {
  auto text = node.is_string() ? node.value<std::string>() : std::nullopt;
  if (!text) return add_wrong_type(walk, node, field, path, "text");
  if (text->empty() && key_of(field).required())
    return walk.add(make_fault(path, "\"\"", "must not be empty"), node);
  if (key_of(field).attachment() && !text->empty()) text = attach(walk, node, *text, path);
  if (!text) return;
  if (auto fault = text_fault(field, *text, path)) return walk.add(std::move(*fault), node);
  message.GetReflection()->SetString(&message, &field, *text);
}

void read_scalar(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                 const std::string& path) {
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return read_enum(walk, node, field, message, path);
    case FieldDescriptor::CPPTYPE_STRING:
      return read_string(walk, node, field, message, path);
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_INT64:
      return read_integer(walk, node, field, message, path);
    case FieldDescriptor::CPPTYPE_BOOL:
      if (!node.is_boolean()) return add_wrong_type(walk, node, field, path, "true or false");
      return message.GetReflection()->SetBool(&message, &field, node.as_boolean()->get());
    default:
      break;
  }
  if (const auto number =
          read_number(walk, node, key_of(field).unit(), example_text(field), &field, path))
    message.GetReflection()->SetDouble(&message, &field, *number);
}

void read_array_of_tables(Walk& walk, const toml::node& node, const FieldDescriptor& field,
                          Message& message, const std::string& path) {
  const toml::array* const array = node.as_array();
  if (array == nullptr)
    return add_wrong_type(walk, node, field, path, "a list of tables, written [[" + path + "]],");
  if (auto fault = count_fault(field, array->size(), path))
    return walk.add(std::move(*fault), node);
  for (std::size_t i = 0; i < array->size(); ++i) {
    const std::string item_path = path + "[" + std::to_string(i) + "]";
    const toml::node& item = *array->get(i);
    walk.mark(item_path, item);
    Message& added = *message.GetReflection()->AddMessage(&message, &field);
    if (const toml::table* const table = item.as_table())
      read_table(walk, *table, added, item_path);
    else
      add_wrong_type(walk, item, field, item_path, "a table");
  }
}

void read_nested(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                 const std::string& path) {
  if (const toml::table* const table = node.as_table())
    return read_table(walk, *table, *message.GetReflection()->MutableMessage(&message, &field),
                      path);
  walk.add(make_fault(path, written(node), type_name(node) + " where a table is expected", "",
                      "write [" + path + "] and its keys below it"),
           node);
}

/// The lines KEY = RANGE of a table; they are judged on the complete case.
void read_ranges(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                 const std::string& path) {
  const toml::table* const table = node.as_table();
  if (table == nullptr)
    return add_wrong_type(walk, node, field, path, "a table of lines KEY = RANGE");
  if (auto fault = count_fault(field, table->size(), path))
    return walk.add(std::move(*fault), node);
  for (const auto& [key, value] : *table) {
    const std::string line = join_path(path, std::string(key.str()));
    const auto range = value.is_string() ? value.value<std::string>() : std::nullopt;
    if (!range || !parse_range(*range)) {
      const bool is_key_without_quotes = value.is_table();
      walk.add(
          make_fault(line, written(value),
                     is_key_without_quotes ? "a table where a range is expected" : "is no range",
                     range_forms,
                     is_key_without_quotes ? "put the key in quotes, as it has points" : ""),
          value);
      continue;
    }
    const Descriptor& entry = *field.message_type();
    for (const auto& [name, text] : {std::pair("key", std::string(key.str())), {"range", *range}})
      if (auto fault = text_fault(*entry.FindFieldByName(name), text, line))
        return walk.add(std::move(*fault), value);
    walk.mark(line, value);
    Message& added = *message.GetReflection()->AddMessage(&message, &field);
    added.GetReflection()->SetString(&added, entry.FindFieldByName("key"), std::string(key.str()));
    added.GetReflection()->SetString(&added, entry.FindFieldByName("range"), *range);
  }
}

/// Paths of all keys of the schema that end in `key`, for a key that stands in the wrong table.
std::string elsewhere(const Message& message, const std::string& path, const std::string& key) {
  if (path.empty() && message.GetDescriptor()->field_count() == 0) return {};
  const Descriptor* const root =
      google::protobuf::DescriptorPool::generated_pool()->FindMessageTypeByName("dccast.v1.Case");
  if (root == nullptr || message.GetDescriptor()->file() != root->file()) return {};
  for (const KeyReference& known : reference(*root))
    if (known.path.ends_with("." + key)) return known.path;
  return {};
}

/// Required keys below a table that is absent altogether.
void add_missing(Walk& walk, const toml::node& place, const Descriptor& descriptor,
                 const toml::table& table, const std::string& path) {
  static const toml::table empty;
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    const std::string key = toml_key(field);
    if (table.contains(key)) continue;
    if (key_of(field).required() &&
        !(key_of(field).unless().size() > 0 && table.contains(key_of(field).unless())))
      walk.outcome.faults.push_back(make_fault(join_path(path, key), "", "required key is missing",
                                               range_text(field),
                                               "e.g. " + key + " = " + example_text(field)));
    else if (is_table(field) && !field.is_repeated())
      add_missing(walk, place, *field.message_type(), empty, join_path(path, key));
  }
}

}  // namespace

void read_field(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                const std::string& path) {
  if (is_ranges(field)) return read_ranges(walk, node, field, message, path);
  if (field.is_repeated()) return read_array_of_tables(walk, node, field, message, path);
  if (is_table(field)) return read_nested(walk, node, field, message, path);
  if (!is_curve(field)) return read_scalar(walk, node, field, message, path);
  v1::Curve curve;
  read_curve(walk, node, field, curve, path);
  if (curve.value_size() > 0)
    message.GetReflection()->MutableMessage(&message, &field)->CopyFrom(curve);
}

void add_unknown(Walk& walk, const toml::node& node, const Message& message,
                 const std::string& path, const std::string& key) {
  if (walk.outcome.faults.size() >= maximum_faults) return;
  const std::vector<std::string> keys = keys_of(*message.GetDescriptor());
  std::string remedy;
  if (const std::string near = nearest(key, keys); !near.empty())
    remedy = "did you mean '" + near + "'?";
  else if (const std::string place = elsewhere(message, path, key); !place.empty())
    remedy = "there is a key " + place;
  else
    remedy = "see `dccast schema`";
  walk.add(
      make_fault(join_path(path, values::shortened(key)), written(node), "unknown key", "", remedy),
      node);
}

void Walk::add(v1::Fault fault, const toml::node& node) {
  mark(fault.field(), node);
  if (outcome.faults.size() < maximum_faults) outcome.faults.push_back(std::move(fault));
}

void Walk::mark(const std::string& path, const toml::node& node) {
  const toml::source_position begin = node.source().begin;
  outcome.source.set(path, {static_cast<int>(begin.line), static_cast<int>(begin.column)});
}

std::string written(const toml::node& node) {
  std::string text;
  if (node.is_string()) {
    text = quoted(*node.value<std::string>());
  } else if (node.is_floating_point()) {
    text = number_text(*node.value<double>());
  } else {
    std::ostringstream stream;
    node.visit([&](const auto& value) { stream << value; });
    text = stream.str();
  }
  return values::shortened(text);
}

std::string type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "a list";
    case toml::node_type::string:
      return "text";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::boolean:
      return "true or false";
    default:
      return "a date or time";
  }
}

std::optional<double> read_number(Walk& walk, const toml::node& node, const std::string& unit,
                                  const std::string& example, const FieldDescriptor* limits,
                                  const std::string& path) {
  const std::string permitted = limits == nullptr ? "" : range_text(*limits);
  const bool dimensionless = unit == "1" || unit.empty();
  const auto refuse = [&](const std::string& message, const std::string& remedy) {
    walk.add(make_fault(path, written(node), message, permitted, remedy), node);
    return std::nullopt;
  };
  Quantity quantity;
  if (node.is_number() && dimensionless)
    quantity.value = node.value<double>();
  else if (node.is_number())
    return refuse("the unit is missing",
                  "write it in " + unit + " or a unit of the same kind, e.g. " + example);
  else if (!node.is_string())
    return refuse(type_name(node) + " where a quantity is expected", "e.g. " + example);
  else
    quantity = parse_quantity(*node.value<std::string>(), unit);
  if (!quantity.value)
    return refuse(quantity.message,
                  (dimensionless ? "write a number, e.g. "
                                 : "expected " + unit + " or a unit of the same kind, e.g. ") +
                      example);
  if (limits != nullptr) {
    if (auto fault = range_fault(*limits, *quantity.value, path, written(node), quantity.unit)) {
      walk.add(std::move(*fault), node);
      return std::nullopt;
    }
  } else if (!std::isfinite(*quantity.value)) {
    return refuse("not a finite number", "e.g. " + example);
  }
  return quantity.value;
}

void read_table(Walk& walk, const toml::table& table, Message& message, const std::string& path) {
  const Descriptor& descriptor = *message.GetDescriptor();
  for (const auto& [key, node] : table) {
    const FieldDescriptor* const field = field_of_key(descriptor, key.str());
    const std::string name(key.str());
    const std::string key_path = join_path(path, name);
    if (field == nullptr) {
      add_unknown(walk, node, message, path, name);
    } else {
      walk.mark(key_path, node);
      read_field(walk, node, *field, message, key_path);
    }
    // The key says better than its value where to look; a list's points keep their own places.
    walk.outcome.source.set(key_path, {static_cast<int>(key.source().begin.line),
                                       static_cast<int>(key.source().begin.column)});
  }
  add_missing(walk, table, descriptor, table, path);
}

}  // namespace dccast::case_file
