#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <toml++/toml.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"

/// Traversal of a parsed TOML file, and parsing of the values of changes; internal part of the
/// reader.
namespace dccast::case_file {

/// Context of the traversal, passed from table to table.
struct Walk {
  const std::filesystem::path* folder;  ///< of attachments; null: they are listed, not read
  ReadOutcome& outcome;

  /// Adds a fault with its position. Faults beyond a maximum number are dropped.
  void add(v1::Fault fault, const toml::node& node);
  /// Adds a fault of the value at `path`.
  void refuse(const toml::node& node, const std::string& path, std::string message,
              std::string permitted = {}, std::string remedy = {});
  /// Records the position of a key.
  void mark(const std::string& path, const toml::source_region& source);
};

/// A value of the file and the field that it is read into.
struct Entry {
  /// The walk, and the node of the file beside the field it is read into.
  Walk& walk;
  const toml::node& node;
  const FieldDescriptor& field;
  std::string path;

  /// Adds a fault at this node. @param permitted  range or choices; empty: none to name
  void refuse(std::string message, std::string permitted = {}, std::string remedy = {}) const {
    walk.refuse(node, path, std::move(message), std::move(permitted), std::move(remedy));
  }
  /// Adds a fault for a value of the wrong type. @param expected  e.g. "a table"
  void refuse_type(const std::string& expected) const;
  /// Adds the fault, if there is one. @return whether there was none
  bool passes(std::optional<v1::Fault> fault) const;
};

/// Reads every key of `table` into `message` and reports those that are missing or unknown.
void read_table(Walk& walk, const toml::table& table, Message& message, const std::string& path);

/// Reads one key's value into its field: a number, text, choice, curve or table.
void read_field(const Entry& entry, Message& message);

/// Adds a fault for an unknown `key` of the table `path`, with the key that may have been meant.
void add_unknown(Walk& walk, const toml::node& node, const Message& message,
                 const std::string& path, const std::string& key);

/// Reads a Curve: one quantity, or a list of [abscissa, value] pairs. Empty on a fault.
v1::Curve read_curve(const Entry& entry);

/// Reads one real number: a string with a unit, or a bare number if the unit is "1".
/// @param unit    unit in the schema
/// @param limits  field whose range applies; null for an abscissa
/// @return        [`unit`]
std::optional<double> read_number(Walk& walk, const toml::node& node, const std::string& unit,
                                  const std::string& example, const FieldDescriptor* limits,
                                  const std::string& path);

/// The number of a field that is real, in its unit and range.
std::optional<double> read_number(const Entry& entry);

/// The value as written in the file, shortened.
std::string written(const toml::node& node);

/// "a number", "text", "a table", ...
std::string type_name(const toml::node& node);

/// The key that a recipe word of a table sets: for `casting_speed` and "scale" the field
/// `casting_speed_factor`, for "shift" `casting_speed_shift_s`; null if the table has no such word.
const FieldDescriptor* recipe_field(const FieldDescriptor& table, std::string_view word);

/// All paths with a recipe word in the message of `path`: "schedule.casting_speed.scale, ...".
std::string recipe_paths(const Descriptor& descriptor, const std::string& path);

/// Reads "0.8", "80 % until 100 mm" or "1.1 from 20 s until 60 s" as a factor over time or cast
/// length that is 1 outside. Columns of faults are counted from the first byte of `text`.
/// @return empty on a fault
v1::Curve read_scale(Walk& walk, const std::string& text, const FieldDescriptor& field,
                     const std::string& path);

/// The value of a change in the form required by the file reader.
struct ChangeValue {
  toml::table table;  ///< holds the value under one key
  /// Column of the parsed text -> column of the value as written, from 1
  std::vector<int> columns;

  const toml::node& node() const { return table.begin()->second; }
};

/// Parses a value as in a file. Text that is not TOML is read as a string, so that quotes may be
/// omitted, also in a list. For a key that holds text or a choice the value is never read as a
/// number.
/// @param field  the key of the value; null if there is no such key
ChangeValue change_value(const std::string& written, const FieldDescriptor* field);

}  // namespace dccast::case_file
