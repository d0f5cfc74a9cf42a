#pragma once

#include <filesystem>
#include <string>

#include <toml++/toml.h>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/schema.hpp"

/// Traversal of a parsed TOML file; internal part of the reader.
namespace dccast::case_file {

/// Context of the traversal, passed from table to table.
struct Walk {
  const std::filesystem::path* folder;  ///< of attachments; null: they are listed, not read
  ReadOutcome& outcome;

  /// Adds a fault with its position. Faults beyond a maximum number are dropped.
  void add(v1::Fault fault, const toml::node& node);
  void mark(const std::string& path, const toml::node& node);
};

/// Reads every key of `table` into `message` and reports those that are missing or unknown.
void read_table(Walk& walk, const toml::table& table, Message& message, const std::string& path);

/// Reads one key's value into its field: a number, text, choice, curve or table.
void read_field(Walk& walk, const toml::node& node, const FieldDescriptor& field, Message& message,
                const std::string& path);

/// Adds a fault for an unknown `key` of the table `path`, with the key that may have been meant.
void add_unknown(Walk& walk, const toml::node& node, const Message& message,
                 const std::string& path, const std::string& key);

/// Reads a Curve: one quantity, or a list of [abscissa, value] pairs. Leaves it empty on a fault.
void read_curve(Walk& walk, const toml::node& node, const FieldDescriptor& field, v1::Curve& curve,
                const std::string& path);

/// Reads one real number: a string with a unit, or a bare number if the unit is "1".
/// @param unit    unit in the schema
/// @param limits  field whose range applies; null for an abscissa
/// @return        [`unit`]
std::optional<double> read_number(Walk& walk, const toml::node& node, const std::string& unit,
                                  const std::string& example, const FieldDescriptor* limits,
                                  const std::string& path);

/// The value as the file has it, cut to a readable length.
std::string written(const toml::node& node);

/// "a number", "text", "a table", ...
std::string type_name(const toml::node& node);

}  // namespace dccast::case_file
