#include "core/base/instructions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string_view>

namespace dccast {
namespace {

Instructions parse_instructions(std::string_view name) {
  if (name == "plain") return Instructions::plain;
  if (name == "avx2") return Instructions::avx2;

  if (name == "avx512") return Instructions::avx512;
  throw std::invalid_argument(fmt::format(
      "environment variable DCCAST_INSTRUCTIONS is \"{}\"; permitted: plain, avx2, avx512", name));
}

}  // namespace

Instructions processor_instructions() {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return Instructions::plain;

  const bool wide = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512vl") &&
                    __builtin_cpu_supports("avx512dq");

  return wide ? Instructions::avx512 : Instructions::avx2;
#else
  return Instructions::plain;
#endif
}

Instructions instructions_for(const char* requested) {
  const Instructions widest = processor_instructions();
  if (requested == nullptr || *requested == '\0') return widest;
  return std::min(parse_instructions(requested), widest);
}

Instructions instructions() {
  static const Instructions chosen = instructions_for(std::getenv("DCCAST_INSTRUCTIONS"));
  return chosen;
}

}  // namespace dccast
