#pragma once

#include <string>
#include <vector>

#include "client/model/json.hpp"

/// Building blocks of the HTML pages. `content`, `value`, captions and notes are HTML already.
namespace dccast::client {

/// Text with &, <, > and quotes made safe for HTML.
std::string html_escaped(const std::string& text);

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
  return card(heading, picture + element("div class='caption'", caption));
}

/// A row of a table of facts: name, value, remark.
inline std::string row(const std::string& name, const std::string& value,
                       const std::string& note = {}) {
  return "<tr><th scope='row'>" + name + "</th><td>" + value + "</td><td>" + note + "</td></tr>";
}

/// A table of figures. @param head  cells @param body  rows
inline std::string figures_table(const std::string& head, const std::string& body) {
  return "<div class='scroll'><table class='figures sheet'><thead>" + head + "</thead><tbody>" +
         body + "</tbody></table></div>";
}

/// A script or style sheet of the pages, embedded at build time (cmake/embed_texts.cmake) from
/// client/html/assets. Reports have them inside; the dashboard serves them.
struct PageAsset {
  std::string name;  ///< "chart.js"
  std::string text;
};
const std::vector<PageAsset>& page_assets();

/// A place where a script of the page (report.js) draws. @param kind  "chart", "slab", "casting"
/// @param data  of the drawing: chart_json(), frames, a complete case with its charts
std::string drawn(const std::string& kind, const Json& data);

/// A whole page that needs no other file. @param title  HTML
std::string whole_page(const std::string& title, const std::string& header,
                       const std::string& body);

}  // namespace dccast::client
