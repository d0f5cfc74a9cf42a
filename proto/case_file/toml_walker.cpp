#include "proto/case_file/toml_walker.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <system_error>
#include <utility>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/config.pb.h"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/uncertainty.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/printable.hpp"

namespace dccast::case_file {
namespace {

constexpr std::size_t maximum_faults = 500;
constexpr std::size_t longest_path_echo = 300;
constexpr std::uintmax_t maximum_attachment_bytes = std::uintmax_t{1} << 30;

void read_enum(const Entry& entry, Message& message) {
  const std::vector<std::string> choices = enum_texts(entry.field);
  const auto text = entry.node.value<std::string>();
  if (!text) return entry.refuse_type(fmt::format("one of the words {}", joined(choices)));
  if (const auto* value = enum_value_of(entry.field, *text))
    return message.GetReflection()->SetEnum(&message, &entry.field, value);

  const std::string near = nearest(*text, choices);
  entry.refuse("unknown choice", joined(choices),
               near.empty() ? "" : fmt::format("did you mean \"{}\"?", near));
}

void read_integer(const Entry& entry, Message& message) {
  if (!entry.node.is_integer()) return entry.refuse_type("a whole number");
  const std::int64_t number = entry.node.as_integer()->get();
  if (!entry.passes(range_fault(entry.field, static_cast<double>(number), entry.path,
                                written(entry.node), "")))
    return;

  const Reflection& reflection = *message.GetReflection();
  if (entry.field.cpp_type() == FieldDescriptor::CPPTYPE_INT64)
    reflection.SetInt64(&message, &entry.field, number);
  else if (std::in_range<std::int32_t>(number))
    reflection.SetInt32(&message, &entry.field, static_cast<std::int32_t>(number));
  else
    entry.refuse("out of range", range_text(entry.field));
}

/// Records a file that the client attaches from another machine; returns its base name.
std::optional<std::string> list_file(const Entry& entry, const std::string& name) {
  const auto base_name = [](const std::string& file) {
    return std::filesystem::path(file).filename().string();
  };
  const std::string base = base_name(name);

  std::vector<std::string>& files = entry.walk.outcome.files;
  for (const std::string& other : files)
    if (other != name && base_name(other) == base) {
      entry.refuse(fmt::format("another attachment is also called {}", base),
                   "files of different names");
      return std::nullopt;
    }

  if (std::ranges::count(files, name) == 0) files.push_back(name);
  return base;
}

/// Adds the file that `name` points to to the attachments; returns its base name.
std::optional<std::string> attach(const Entry& entry, const std::string& name) {
  if (entry.walk.folder == nullptr) return list_file(entry, name);

  const std::filesystem::path file = *entry.walk.folder / name;
  std::error_code error;
  const auto refuse = [&](const char* reason, const std::string& subject) {
    entry.refuse(values::shortened(fmt::format("{}{}", reason, subject), longest_path_echo),
                 "a readable file, relative to the folder of the case file");
    return std::nullopt;
  };
  if (!std::filesystem::exists(file, error)) return refuse("no such file: ", file.string());
  if (!std::filesystem::is_regular_file(file, error)) return refuse("not a file: ", file.string());
  if (std::filesystem::file_size(file, error) > maximum_attachment_bytes)
    return refuse("larger than 1 GiB: ", file.string());

  AttachedFile attachment{.name = file.filename().string(), .path = file};
  try {
    attachment.sha256 = values::sha256_of_file(file);
    attachment.bytes = static_cast<std::int64_t>(std::filesystem::file_size(file));
  } catch (const std::system_error&) {
    return refuse("cannot be read: ", file.string());
  }
  for (const AttachedFile& other : entry.walk.outcome.attachments)
    if (other.name == attachment.name && other.sha256 != attachment.sha256)
      return refuse("another attachment is also called ", attachment.name);

  return entry.walk.outcome.attachments.emplace_back(std::move(attachment)).name;
}

void read_string(const Entry& entry, Message& message) {
  const FieldDescriptor& field = entry.field;
  auto text = entry.node.is_string() ? entry.node.value<std::string>() : std::nullopt;
  if (!text) return entry.refuse_type("text");
  if (text->empty() && key_of(field).required()) return entry.refuse("must not be empty");
  if (names_file(field, *text)) text = attach(entry, *text);
  if (text && entry.passes(text_fault(field, *text, entry.path)))
    message.GetReflection()->SetString(&message, &field, *text);
}

std::vector<std::string> keys_of(const Descriptor& descriptor) {
  std::vector<std::string> keys;
  for (const FieldDescriptor* const field : fields_of(descriptor)) keys.push_back(toml_key(*field));
  return keys;
}

/// Reads a table that is written as a row, the values of its keys in their order.
void read_row(const Entry& entry, const toml::array& row, Message& message) {
  const auto fields = fields_of(*message.GetDescriptor());
  if (row.size() != fields.size())
    return entry.refuse(fmt::format("a row of {} values", row.size()),
                        fmt::format("[{}]", joined(keys_of(*message.GetDescriptor()))));
  for (std::size_t i = 0; i < row.size(); ++i)
    read_field({entry.walk, *row.get(i), *fields[i], join_path(entry.path, toml_key(*fields[i]))},
               message);
}

void read_array_of_tables(const Entry& entry, Message& message) {
  const auto& [walk, node, field, path] = entry;
  const toml::array* const array = node.as_array();
  if (array == nullptr)
    return entry.refuse_type(fmt::format("a list of tables, written [[{}]],", path));
  if (!entry.passes(count_fault(field, array->size(), path))) return;

  for (std::size_t i = 0; i < array->size(); ++i) {
    const Entry item{walk, *array->get(i), field, element_path(path, i)};
    walk.mark(item.path, item.node.source());
    Message& added = *message.GetReflection()->AddMessage(&message, &field);
    if (const toml::table* const table = item.node.as_table())
      read_table(walk, *table, added, item.path);
    else if (const toml::array* const row = item.node.as_array())
      read_row(item, *row, added);
    else
      item.refuse_type("a table");
  }
}

void read_nested(const Entry& entry, Message& message) {
  if (const toml::table* const table = entry.node.as_table())
    return read_table(entry.walk, *table,
                      *message.GetReflection()->MutableMessage(&message, &entry.field), entry.path);

  entry.refuse(fmt::format("{} where a table is expected", type_name(entry.node)), "",
               fmt::format("write [{}] and below it its keys: {}", entry.path,
                           joined(keys_of(*entry.field.message_type()))));
}

/// Reads the lines KEY = RANGE of a table; they are checked on the complete case.
void read_ranges(const Entry& entry, Message& message) {
  const auto& [walk, node, field, path] = entry;
  const toml::table* const table = node.as_table();
  if (table == nullptr) return entry.refuse_type("a table of lines KEY = RANGE");
  if (!entry.passes(count_fault(field, table->size(), path))) return;

  const FieldDescriptor& key_field = *field.message_type()->FindFieldByName("key");
  const FieldDescriptor& range_field = *field.message_type()->FindFieldByName("range");
  for (const auto& [name, value] : *table) {
    const std::string key(name.str());
    const Entry line{walk, value, field, join_path(path, key)};
    const auto range = value.is_string() ? value.value<std::string>() : std::nullopt;
    if (value.is_table()) {
      line.refuse("a table where a range is expected", range_forms,
                  "put the key in quotes, because it contains points");
    } else if (!range || !parse_range(*range)) {
      line.refuse("is no range", range_forms);
    } else {
      if (!line.passes(text_fault(key_field, key, line.path)) ||
          !line.passes(text_fault(range_field, *range, line.path)))
        return;
      walk.mark(line.path, value.source());
      Message& added = *message.GetReflection()->AddMessage(&message, &field);
      added.GetReflection()->SetString(&added, &key_field, key);
      added.GetReflection()->SetString(&added, &range_field, *range);
    }
  }
}

/// Whether the table is one of the settings of dccastd.
bool is_setting(const Descriptor& table) {
  return table.file() == v1::DaemonConfig::descriptor()->file();
}

/// A path of the schema for a key that is in the wrong table, or in the outermost one with an
/// underscore for the point: "log_level" for log.level.
std::string find_in_other_table(const Descriptor& table, const std::string& key) {
  const Descriptor& root =
      is_setting(table) ? *v1::DaemonConfig::descriptor() : *v1::Case::descriptor();
  if (table.file() != root.file()) return {};

  for (const KeyReference& known : reference(root)) {
    std::string underscored = known.path;
    std::ranges::replace(underscored, '.', '_');
    if (known.path.ends_with(fmt::format(".{}", key)) || underscored == key) return known.path;
  }
  return {};
}

/// Adds faults for missing required keys of a table, and of the tables below it that are absent.
void add_missing(Walk& walk, const Descriptor& descriptor, const toml::table& table,
                 const std::string& path) {
  static const toml::table empty;
  for (const FieldDescriptor* const field : fields_of(descriptor)) {
    const std::string key = toml_key(*field);
    if (table.contains(key)) continue;

    const std::string& other = key_of(*field).unless();
    const bool replaced = !other.empty() && table.contains(other);
    if (key_of(*field).required() && !replaced) {
      walk.outcome.missing_keys.push_back(join_path(path, key));
      walk.outcome.faults.push_back(missing_fault(*field, join_path(path, key)));
    } else if (is_table(*field) && !field->is_repeated() && !key_of(*field).only_if_given()) {
      add_missing(walk, *field->message_type(), empty, join_path(path, key));
    }
  }
}

}  // namespace

void read_field(const Entry& entry, Message& message) {
  const FieldDescriptor& field = entry.field;
  const Reflection& reflection = *message.GetReflection();
  if (is_ranges(field)) return read_ranges(entry, message);
  if (field.is_repeated()) return read_array_of_tables(entry, message);

  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_ENUM:
      return read_enum(entry, message);
    case FieldDescriptor::CPPTYPE_STRING:
      return read_string(entry, message);
    case FieldDescriptor::CPPTYPE_INT32:
    case FieldDescriptor::CPPTYPE_INT64:
      return read_integer(entry, message);
    case FieldDescriptor::CPPTYPE_BOOL:
      if (!entry.node.is_boolean()) return entry.refuse_type("true or false");
      return reflection.SetBool(&message, &field, entry.node.as_boolean()->get());
    case FieldDescriptor::CPPTYPE_DOUBLE:
      if (const auto number = read_number(entry)) reflection.SetDouble(&message, &field, *number);
      return;
    default:
      break;
  }

  if (is_table(field)) return read_nested(entry, message);
  if (const v1::Curve curve = read_curve(entry); curve.value_size() > 0)
    reflection.MutableMessage(&message, &field)->CopyFrom(curve);
}

void add_unknown(Walk& walk, const toml::node& node, const Message& message,
                 const std::string& path, const std::string& key) {
  if (walk.outcome.faults.size() >= maximum_faults) return;
  const Descriptor& table = *message.GetDescriptor();

  std::string remedy = is_setting(table) ? "see `dccast schema --daemon`" : "see `dccast schema`";
  if (const std::string place = find_in_other_table(table, key); !place.empty())
    remedy = fmt::format("there is a key {}", place);
  else if (const std::string near = nearest(key, keys_of(table)); !near.empty())
    remedy = fmt::format("did you mean '{}'?", near);

  walk.refuse(node, join_path(path, values::shortened(key)), "unknown key", "", remedy);
}

void Walk::add(v1::Fault fault, const toml::node& node) {
  mark(fault.field(), node.source());
  if (outcome.faults.size() < maximum_faults) outcome.faults.push_back(std::move(fault));
}

void Walk::refuse(const toml::node& node, const std::string& path, std::string message,
                  std::string permitted, std::string remedy) {
  add(make_fault(path, written(node), std::move(message), std::move(permitted), std::move(remedy)),
      node);
}

void Walk::mark(const std::string& path, const toml::source_region& source) {
  outcome.source.set(path,
                     {static_cast<int>(source.begin.line), static_cast<int>(source.begin.column)});
}

void Entry::refuse_type(const std::string& expected) const {
  refuse(fmt::format("{} where {} is expected", type_name(node), expected), range_text(field),
         fmt::format("e.g. {} = {}", toml_key(field), example_text(field)));
}

bool Entry::passes(std::optional<v1::Fault> fault) const {
  if (fault) walk.add(std::move(*fault), node);
  return !fault;
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
  const bool dimensionless = unit == "1" || unit.empty();
  const auto refuse = [&](const std::string& message, const std::string& remedy) {
    walk.refuse(node, path, message, limits == nullptr ? "" : range_text(*limits), remedy);
    return std::nullopt;
  };

  Quantity quantity;
  if (node.is_number() && dimensionless)
    quantity.value = node.value<double>();
  else if (node.is_number())
    return refuse("the unit is missing",
                  fmt::format("write it in {} or a unit of the same kind, e.g. {}", unit, example));
  else if (!node.is_string())
    return refuse(fmt::format("{} where a quantity is expected", type_name(node)),
                  fmt::format("e.g. {}", example));
  else
    quantity = parse_quantity(*node.value<std::string>(), unit);
  if (!quantity.value)
    return refuse(quantity.message,
                  dimensionless ? fmt::format("write a number, e.g. {}", example)
                                : fmt::format("expected {} or a unit of the same kind, e.g. {}",
                                              unit, example));

  if (limits == nullptr && !std::isfinite(*quantity.value))
    return refuse("not a finite number", fmt::format("e.g. {}", example));
  if (limits != nullptr && !Entry{walk, node, *limits, path}.passes(range_fault(
                               *limits, *quantity.value, path, written(node), quantity.unit)))
    return std::nullopt;
  return quantity.value;
}

std::optional<double> read_number(const Entry& entry) {
  return read_number(entry.walk, entry.node, key_of(entry.field).unit(), example_text(entry.field),
                     &entry.field, entry.path);
}

void read_table(Walk& walk, const toml::table& table, Message& message, const std::string& path) {
  const Descriptor& descriptor = *message.GetDescriptor();
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    const std::string key_path = join_path(path, name);
    if (const FieldDescriptor* const field = field_of_key(descriptor, name)) {
      walk.mark(key_path, node.source());
      read_field({walk, node, *field, key_path}, message);
    } else {
      add_unknown(walk, node, message, path, name);
    }

    // A fault is reported at the key, not at its value; points of a list keep their own positions.
    walk.mark(key_path, key.source());
  }
  add_missing(walk, descriptor, table, path);
}

}  // namespace dccast::case_file
