#pragma once

#include <functional>
#include <string>
#include <vector>

#include "proto/figures/rounding.hpp"

namespace dccast::client {

using Rows = std::vector<std::vector<std::string>>;  ///< cells by row

/// Text table with columns as wide as needed, two blanks between them, no trailing blanks.
class Table {
public:
  /// A heading that begins with '>' makes a column that is set to the right (numbers).
  explicit Table(std::vector<std::string> headings, Rows rows = {});
  /// Adds a row; its cells are UTF-8, counted by characters.
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  /// The table with columns as wide as their widest cell.
  std::string text() const;

private:
  std::vector<bool> right_;
  Rows rows_;
};

/// A line of a sheet of facts, the values below each other.
std::string sheet_line(const std::string& name, const std::string& value);

/// A text as a cell of a CSV file. One that a spreadsheet would take for a formula has an
/// apostrophe before it.
std::string csv_text(const std::string& text);

using figures::fixed, figures::mm, figures::mm_decimals, figures::mm_errors;

/// "a, b, c". @param text_of  gives the text of an element
template <class Elements, class TextOf = std::identity>
std::string joined(const Elements& elements, const std::string& separator = ", ",
                   TextOf text_of = {}) {
  std::string list;
  for (const auto& element : elements) {
    const std::string& text = std::invoke(text_of, element);
    list += (list.empty() ? "" : separator) + text;
  }
  return list;
}

}  // namespace dccast::client
