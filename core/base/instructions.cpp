#include "core/base/instructions.hpp"

#include <algorithm>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <string_view>

namespace dccast {
namespace {

Instructions named(std::string_view name) {
  if (name == "plain") return Instructions::plain;
  if (name == "avx2") return Instructions::avx2;
  if (name == "avx512") return Instructions::avx512;
  throw std::invalid_argument("DCCAST_INSTRUCTIONS is \"" + std::string(name) +
                              "\": give plain, avx2 or avx512");
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

Instructions instructions_for(const char* asked) {
  const Instructions widest = processor_instructions();
  if (asked == nullptr || *asked == '\0') return widest;
  return std::min(named(asked), widest);
}

Instructions instructions() {
  static const Instructions chosen = instructions_for(std::getenv("DCCAST_INSTRUCTIONS"));
  return chosen;
}

}  // namespace dccast
