#pragma once

#include <cstdint>
#include <string>

namespace dccast::service {

/// The page token of a list by age, newest first: "<creation time in ms>.<id>" of the last entry of
/// the page before. @return whether it is one; an empty token changes nothing
bool read_age_token(const std::string& token, std::int64_t& before_ms, std::string& before_id);

std::string age_token(std::int64_t created_ms, const std::string& id);

}  // namespace dccast::service
