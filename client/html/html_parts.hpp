#pragma once

#include <string>
#include <vector>

#include "client/html/svg_chart.hpp"

/// Building blocks of the HTML pages. `content`, `value` and notes are HTML already.
namespace dccast::client::render {

/// "<h1>content</h1>" for "h1"; attributes may follow the tag's name.
inline std::string element(const std::string& tag, const std::string& content) {
  return "<" + tag + ">" + content + "</" + tag.substr(0, tag.find(' ')) + ">";
}

inline std::string card(const std::string& heading, const std::string& content) {
  return "<section class='card'><h2>" + heading + "</h2>" + content + "</section>";
}

/// A card with a picture and its caption.
inline std::string figure(const std::string& heading, const std::string& picture,
                          const std::string& caption) {
  return card(heading, "<figure>" + picture + "<figcaption>" + caption + "</figcaption></figure>");
}

/// A row of a table of facts: name, value, remark.
inline std::string row(const std::string& name, const std::string& value,
                       const std::string& note = {}) {
  return "<tr><th scope='row'>" + name + "</th><td>" + value + "</td><td>" + note + "</td></tr>";
}

/// A table of figures. @param headings, rows  texts
inline std::string table_of(const std::vector<std::string>& headings,
                            const std::vector<std::vector<std::string>>& rows) {
  const auto row = [](const std::vector<std::string>& cells, const char* tag) {
    std::string html = "<tr>";
    for (const std::string& cell : cells)
      html += std::string("<") + tag + ">" + html_escaped(cell) + "</" + tag + ">";
    return html + "</tr>";
  };
  std::string html = "<div class='scroll'><table class='figures'><thead>" + row(headings, "th") +
                     "</thead><tbody>";
  for (const auto& cells : rows) html += row(cells, "td");
  return html + "</tbody></table></div>";
}

}  // namespace dccast::client::render
