#include "client/html/html_parts.hpp"

#include <stdexcept>

namespace dccast::client::render {
const std::string& page_asset(const std::string& name) {
  for (const PageAsset& asset : page_assets())
    if (asset.name == name) return asset.text;
  throw std::logic_error("page_asset: there is no " + name);
}

std::string whole_page(const std::string& title, const std::string& header,
                       const std::string& body) {
  return "<!DOCTYPE html><html lang='en'><head><meta charset='utf-8'><meta name='viewport' "
         "content='width=device-width, initial-scale=1'>" +
         element("title", title) + element("style", page_asset("report.css")) + "</head><body><main>" +
         element("header", header) + body + "</main></body></html>\n";
}

std::string svg_file(const std::string& attributes, const std::string& content) {
  return "<?xml version='1.0' encoding='UTF-8'?>\n<svg xmlns='http://www.w3.org/2000/svg' " +
         attributes + ">" + element("style", page_asset("report.css")) + content + "</svg>\n";
}

}  // namespace dccast::client::render
