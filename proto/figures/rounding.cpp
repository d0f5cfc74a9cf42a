#include "proto/figures/rounding.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/core.h>

namespace dccast::figures {

std::string fixed(double value, int decimals) {
  if (!std::isfinite(value)) return "-";
  std::string text = fmt::format("{:.{}f}", value, std::max(decimals, 0));
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return is_zero && text.starts_with('-') ? text.substr(1) : text;
}

std::string mm(double metres, int decimals) {
  return fixed(1e3 * metres, decimals);
}

int decimals_by_error(const std::optional<double>& error, int digits, int most) {
  if (!error || !std::isfinite(*error) || *error <= 0.0) return most;

  const int decimals = digits - 1 - static_cast<int>(std::floor(std::log10(*error)));
  // 0.996 is rounded to 1.0, which has one decimal less.
  const bool carries =
      std::round(*error * std::pow(10.0, decimals)) >= std::round(std::pow(10.0, digits));
  return std::clamp(carries ? decimals - 1 : decimals, 0, most);
}

int mm_decimals(const std::optional<double>& error_m) {
  constexpr int two_digits = 2;
  constexpr int hundredths = 2;  // no curl is known better
  return decimals_by_error(1e3 * error_m.value_or(0.0), two_digits, hundredths);
}

std::string errors_text(double lower, double upper, int decimals) {
  if (lower == upper) return "± " + fixed(upper, decimals);
  // An error that rounds to nothing reads as none: "-0 +0.01".
  const double least = 0.5 * std::pow(10.0, -decimals);
  const auto side = [&](double error) { return error < least ? "0" : fixed(error, decimals); };
  return fmt::format("-{} +{}", side(lower), side(upper));
}

std::string mm_errors(double lower_m, double upper_m, int decimals) {
  return errors_text(1e3 * lower_m, 1e3 * upper_m, decimals);
}

std::string with_errors(const std::string& figure, const std::string& errors) {
  if (errors.empty()) return figure;
  return figure + (errors.starts_with('-') ? ", " : " ") + errors;
}

}  // namespace dccast::figures
