#pragma once

#include <string>
#include <vector>

#include "core/case/case.hpp"

namespace dccast::casting {

/// The ranges of time, cast length and depth that a casting passes through.
struct Course {
  double begin = 0.0;        ///< [s]
  double end = 0.0;          ///< [s]
  double cast_length = 0.0;  ///< [m] at the end
  double depth = 0.0;        ///< [m] of the metal at the end
};

Course course_of(const Case& casting_case);

/// The values that a table takes during the course: at both ends of the range and at the points in
/// between.
/// @param curve  against time [s] or cast length [m]; of other tables all values are returned
/// @return       [unit of the curve]
std::vector<double> values_in(const Curve& curve, const Course& course);

/// Whether a table never takes effect: all its points lie before or after the course, so that one
/// value holds throughout. False for constants and for tables against anything but time and cast
/// length.
/// @param shift  [s] delay of a table against time
bool never_reached(const Curve& curve, const Course& course, double shift = 0.0);

/// Joins texts; of a long list only the first ones: "a, b, c and 12 more".
std::string listed(const std::vector<std::string>& texts);

}  // namespace dccast::casting
