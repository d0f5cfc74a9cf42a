#pragma once

#include <string>
#include <vector>

#include "client/web/resources.hpp"

namespace dccast::client {

/// A file of the dashboard, embedded at build time (cmake/embed_texts.cmake) from
/// client/web/assets.
struct Asset {
  std::string name;  ///< "app.js"
  std::string text;
};

/// All files of the dashboard.
const std::vector<Asset>& assets();

/// Gives a web server the dashboard: its pages, the calls of the service that they make, and what
/// the client makes of results (curls with their error, reports, comparisons, frames).
/// @param cases  case files to begin a what-if with, besides the shipped ones
void add_dashboard(WebServer& server, const Connect& connect,
                   const std::vector<std::string>& cases);

}  // namespace dccast::client
