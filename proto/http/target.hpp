#pragma once

#include <map>
#include <string>
#include <string_view>

namespace dccast::http {

/// The text with %XX decoded; a "%" that begins no such pair stays as it is.
std::string decoded(std::string_view text);

/// A target of a request, "/compare/?job=1&job=2", in its parts.
struct Target {
  std::string path;                               ///< as sent: "/compare/"
  std::multimap<std::string, std::string> query;  ///< decoded, "+" as a space
};
/// Splits path and query of a request and decodes both.
Target parse_target(std::string_view target);

}  // namespace dccast::http
