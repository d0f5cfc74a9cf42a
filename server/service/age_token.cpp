#include "server/service/age_token.hpp"

#include <charconv>

#include "proto/values/digests.hpp"

namespace dccast::service {

bool read_age_token(const std::string& token, std::int64_t& before_ms, std::string& before_id) {
  if (token.empty()) return true;
  const auto dot = token.find('.');
  if (dot == std::string::npos || !values::is_uuid(token.substr(dot + 1))) return false;
  before_id = token.substr(dot + 1);
  const auto [end, error] = std::from_chars(token.data(), token.data() + dot, before_ms);
  return error == std::errc() && end == token.data() + dot;
}

std::string age_token(std::int64_t created_ms, const std::string& id) {
  return std::to_string(created_ms) + "." + id;
}

}  // namespace dccast::service
