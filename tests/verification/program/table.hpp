#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dccast::verification {

/// A cell is a number, a text, or null where there is nothing to say.
using Cell = nlohmann::json;

/// What is printed: as Markdown, as JSON (rows as objects by column), or inside the HTML report.
struct Table {
  std::string title;
  std::string setup;  ///< mesh, step and norm used
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;
  std::vector<std::string> remarks;
  std::vector<std::string> missed;  ///< what must not happen and did: the program then fails
};

std::string text_of(const Cell& cell);
std::string to_markdown(const Table& table);
nlohmann::json to_json(const Table& table);
std::string to_html(const Table& table);
/// Text with the characters that HTML gives a meaning replaced.
std::string escaped(const std::string& text);

}  // namespace dccast::verification
