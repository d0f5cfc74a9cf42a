#include "core/base/errors.hpp"

#include <cstdio>
#include <utility>

namespace dccast {

namespace {

std::string shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", value);
  return text;
}

std::string summary(const std::vector<Fault>& faults) {
  std::string text;
  for (const Fault& fault : faults) {
    if (!text.empty()) text += "; ";
    text += fault.field + " = " + fault.value + ": " + fault.message;
  }
  return text;
}

}  // namespace

void Faults::add(std::string_view field, double value, std::string_view message,
                 std::string_view permitted, std::string_view remedy) {
  add(field, shortest(value), message, permitted, remedy);
}

void Faults::add(std::string_view field, std::string_view value, std::string_view message,
                 std::string_view permitted, std::string_view remedy) {
  list_.push_back({std::string(field), std::string(value), std::string(message),
                   std::string(permitted), std::string(remedy)});
}

InvalidCase::InvalidCase(Faults faults)
    : std::runtime_error(summary(faults.list())), faults_(std::move(faults)) {}

SolveFailed::SolveFailed(const std::string& what, double time, double time_step,
                         std::vector<double> residual_history)
    : std::runtime_error(what), time_(time), time_step_(time_step),
      residual_history_(std::move(residual_history)) {}

}  // namespace dccast
