#pragma once

#include <cstddef>
#include <span>
#include <string>

namespace dccast::values {

/// Two digits a byte, lower case, as every value of the contract is written.
std::string hexadecimal(std::span<const unsigned char> bytes);

/// So many bytes from the system's random numbers. @throws std::system_error
std::string random_hexadecimal(std::size_t bytes);

}  // namespace dccast::values
