#include "client/html/html_parts.hpp"

#include <string_view>

#include "client/html/frame_bytes.hpp"

namespace dccast::client {
namespace {

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (auto at = text.find(from); at != text.npos; at = text.find(from, at + to.size()))
    text.replace(at, from.size(), to);
}

std::string styles() {
  std::string css;
  for (const PageAsset& asset : page_assets())
    if (asset.name == "style.css") css += asset.text;
  return element("style", css);
}

/// The modules of the dashboard that draw. A page opened from a file cannot load modules, and one
/// that is a data: URL has no folder: an import map gives each its name.
std::string scripts() {
  Json modules = Json::object();
  for (const PageAsset& asset : page_assets()) {
    if (!asset.name.ends_with(".js")) continue;
    std::string text = asset.text;
    replace_all(text, "from './", "from '");
    modules[asset.name] = "data:text/javascript;base64," + base64(text);
  }
  return element("script type='importmap'", Json{{"imports", modules}}.dump()) +
         element("script type='module'", "import 'report.js';");
}

constexpr const char* without_scripts =
    "<noscript><p class='note'>Charts and the slab are drawn by the script in this page, which "
    "does "
    "not run here. Figures, tables and findings are complete.</p></noscript>";

}  // namespace

std::string html_escaped(const std::string& text) {
  constexpr std::string_view special = "&<>\"'";
  constexpr const char* names[] = {"&amp;", "&lt;", "&gt;", "&quot;", "&#39;"};
  std::string escaped;
  for (const char c : text) {
    const auto at = special.find(c);
    escaped += at == special.npos ? std::string(1, c) : names[at];
  }
  return escaped;
}

std::string drawn(const std::string& kind, const Json& data) {
  std::string text = data.dump();
  replace_all(text, "<", "\\u003c");  // a title must not end the element
  return element("div class='drawn' data-kind='" + kind + "'",
                 element("script type='application/json'", text));
}

std::string whole_page(const std::string& title, const std::string& header,
                       const std::string& body) {
  const bool has_drawings = body.find("class='drawn'") != body.npos;
  return "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width, initial-scale=1'>" +
         element("title", title) + styles() + "</head><body class='report'><main>" +
         element("header", header) + (has_drawings ? without_scripts : "") + body + "</main>" +
         (has_drawings ? scripts() : "") + "</body></html>\n";
}

}  // namespace dccast::client
