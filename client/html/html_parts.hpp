#pragma once

#include <string>
#include <vector>

#include "client/html/svg_chart.hpp"

/// Building blocks of the HTML pages. `content`, `value`, captions and notes are HTML already.
namespace dccast::client::render {

/// "<h1>content</h1>" for "h1"; attributes may follow the tag's name.
inline std::string element(const std::string& tag, const std::string& content) {
  return "<" + tag + ">" + content + "</" + tag.substr(0, tag.find(' ')) + ">";
}

/// A box with a heading. @param content  HTML, not escaped
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

/// The cells of a row of a table of figures. @param texts  not yet HTML
inline std::string cells(const std::vector<std::string>& texts, const std::string& tag = "td") {
  std::string html;
  for (const std::string& text : texts) html += element(tag, html_escaped(text));
  return html;
}

/// A table of figures. @param head  cells @param body  rows
inline std::string figures_table(const std::string& head, const std::string& body) {
  return "<div class='scroll'><table class='figures'><thead>" + head + "</thead><tbody>" + body +
         "</tbody></table></div>";
}

/// A style sheet or script of the pages, embedded at build time (cmake/embed_texts.cmake) from
/// client/html/assets.
struct PageAsset {
  std::string name;  ///< "report.css"
  std::string text;
};
const std::vector<PageAsset>& page_assets();
/// The text of an asset. @throws std::logic_error  there is none of this name
const std::string& page_asset(const std::string& name);

/// A whole page that needs no other file. @param title  HTML
std::string whole_page(const std::string& title, const std::string& header,
                       const std::string& body);

/// A drawing as an SVG file of its own. @param attributes, content  of its outermost element
std::string svg_file(const std::string& attributes, const std::string& content);

}  // namespace dccast::client::render
