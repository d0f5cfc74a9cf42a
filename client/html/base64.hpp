#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace dccast::client::render {

/// 16-bit numbers, the lower byte first, as base64 (RFC 4648).
std::string base64(const std::vector<std::uint16_t>& numbers);

}  // namespace dccast::client::render
