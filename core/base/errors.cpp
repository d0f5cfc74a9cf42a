#include "core/base/errors.hpp"

#include <fmt/format.h>

namespace dccast {

void Faults::add(std::string_view field, double value, std::string_view message,
                 std::string_view permitted, std::string_view remedy) {
  add(field, fmt::format("{:.6g}", value), message, permitted, remedy);
}

void Faults::add(std::string_view field, std::string_view value, std::string_view message,
                 std::string_view permitted, std::string_view remedy) {
  list_.push_back({std::string(field), std::string(value), std::string(message),
                   std::string(permitted), std::string(remedy)});
}

std::string Faults::summary() const {
  std::string text;
  for (const Fault& fault : list_) {
    if (!text.empty()) text += "; ";
    text += fmt::format("{} = {}: {}", fault.field, fault.value, fault.message);
  }
  return text;
}

}  // namespace dccast
