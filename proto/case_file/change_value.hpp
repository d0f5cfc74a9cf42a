#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "proto/case_file/schema.hpp"

namespace dccast::case_file {

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
