#pragma once

#include <cstdio>
#include <string>
#include <utility>

#include "core/findings/placed_figure.hpp"
#include "core/results/finding.hpp"

namespace dccast::casting {

/// Like printf, but returns a string.
template <class... Values>
std::string sentence(const char* format, Values... values) {
  char text[500];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

inline constexpr double in_mm = 1e3;  ///< [mm/m] for messages

/// A measured figure and the limit that a key of the case sets.
struct Measured {
  PlacedFigure figure;
  double limit = 0.0;     ///< [`unit`]
  const char* unit = "";  ///< of figure and limit
  const char* key = "";
};

inline results::Finding finding_of(const char* code, results::Severity severity,
                                   std::string message, Measured measured) {
  results::Finding finding;
  finding.code = code;
  finding.severity = severity;
  finding.message = std::move(message);
  finding.place = std::move(measured.figure.place);
  finding.value = measured.figure.value;
  finding.limit = measured.limit;
  finding.unit = measured.unit;
  finding.key = measured.key;
  return finding;
}

}  // namespace dccast::casting
