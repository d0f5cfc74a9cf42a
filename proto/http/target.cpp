#include "proto/http/target.hpp"

#include <algorithm>
#include <charconv>

namespace dccast::http {
namespace {

std::string decoded_value(std::string_view text) {
  std::string spaced(text);
  std::ranges::replace(spaced, '+', ' ');
  return decoded(spaced);
}

}  // namespace

std::string decoded(std::string_view text) {
  constexpr std::size_t digits = 2;
  std::string plain;

  for (std::size_t i = 0; i < text.size(); ++i) {
    unsigned char byte = 0;
    const char* first = text.data() + i + 1;
    const bool is_whole = text[i] == '%' && i + digits < text.size();

    if (is_whole && std::from_chars(first, first + digits, byte, 16).ptr == first + digits) {
      plain += static_cast<char>(byte);
      i += digits;
    } else {
      plain += text[i];
    }
  }
  return plain;
}

Target parse_target(std::string_view target) {
  const auto question = target.find('?');
  Target parts{.path = std::string(target.substr(0, question)), .query = {}};
  if (question == std::string_view::npos) return parts;

  std::string_view rest = target.substr(question + 1);
  while (!rest.empty()) {
    const std::string_view pair = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), pair.size() + 1));
    if (pair.empty()) continue;

    const auto equals = std::min(pair.find('='), pair.size());
    const std::string_view value = pair.substr(std::min(equals + 1, pair.size()));
    parts.query.emplace(decoded_value(pair.substr(0, equals)), decoded_value(value));
  }
  return parts;
}

}  // namespace dccast::http
