#include "client/uuid.hpp"

#include <array>
#include <cstdio>
#include <random>

namespace dccast::client {

std::string make_uuid() {
  std::random_device random;
  std::array<unsigned, 4> word{};
  for (unsigned& one : word) one = random();
  word[1] = (word[1] & 0xFFFF0FFFu) | 0x00004000u;  // version 4
  word[2] = (word[2] & 0x3FFFFFFFu) | 0x80000000u;  // variant of RFC 4122
  char text[40];
  std::snprintf(text, sizeof text, "%08x-%04x-%04x-%04x-%04x%08x", word[0], word[1] >> 16,
                word[1] & 0xFFFFu, word[2] >> 16, word[2] & 0xFFFFu, word[3]);
  return text;
}

}  // namespace dccast::client
