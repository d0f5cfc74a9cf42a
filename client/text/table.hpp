#pragma once

#include <string>
#include <vector>

namespace dccast::client::render {

/// Text table with columns as wide as needed, two blanks between them, no trailing blanks.
class Table {
public:
  /// A heading that begins with '>' makes a column that is set to the right (numbers).
  explicit Table(std::vector<std::string> headings);
  void add(std::vector<std::string> row) { rows_.push_back(std::move(row)); }
  std::string text() const;

private:
  std::vector<bool> right_;
  std::vector<std::vector<std::string>> rows_;
};

/// A text as a cell of a CSV file. One that a spreadsheet would take for a formula has an
/// apostrophe before it.
std::string csv_text(const std::string& text);

/// A number [any unit] with a fixed number of decimals; "-" if it is not finite.
std::string fixed(double value, int decimals);

}  // namespace dccast::client::render
