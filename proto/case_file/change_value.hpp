#pragma once

#include <string>
#include <vector>

#include <toml++/toml.h>

#include "proto/case_file/schema.hpp"

namespace dccast::case_file {

/// The value of a change as the reader of files wants it.
struct ChangeValue {
  toml::table table;  ///< holds the value under one key
  std::vector<int>
      columns;  ///< column of the parsed text -> column of the value as written, from 1

  const toml::node& node() const { return table.begin()->second; }
};

/// The value as in a file; text that is no TOML is taken as a string, so that quotes may be left
/// out, also in a list. Text for a key that holds text or a choice is never taken as a number.
/// @param field  the key it is for; null where there is no such key
ChangeValue change_value(const std::string& written, const FieldDescriptor* field);

}  // namespace dccast::case_file
