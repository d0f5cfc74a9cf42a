#pragma once

#include <string>
#include <vector>

namespace dccast::client::web {

/// A file of the dashboard, embedded at build time (cmake/embed_texts.cmake) from
/// client/web/assets.
struct Asset {
  std::string name;  ///< "app.js"
  std::string text;
};

const std::vector<Asset>& assets();

}  // namespace dccast::client::web
