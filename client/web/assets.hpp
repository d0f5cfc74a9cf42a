#pragma once

#include <string>
#include <vector>

namespace dccast::client::web {

/// A file of the dashboard, embedded at build time from client/web/assets.
struct Asset {
  std::string name;  ///< "app.js"
  std::string text;
};

const std::vector<Asset>& assets();

}  // namespace dccast::client::web
