#include "proto/values/hexadecimal.hpp"

#include <sys/random.h>

#include <cerrno>
#include <system_error>
#include <vector>

namespace dccast::values {

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::string random_hexadecimal(std::size_t bytes) {
  std::vector<unsigned char> random(bytes);
  // Up to 256 bytes come at once and without interruption, getrandom(2).
  if (getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    throw std::system_error(errno, std::generic_category(), "getrandom");
  return hexadecimal(random);
}

}  // namespace dccast::values
