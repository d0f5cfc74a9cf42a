#pragma once

#include <string>
#include <vector>

#include "core/casting/case.hpp"

namespace dccast::casting {

/// What a casting comes through from its beginning to its end.
struct Course {
  double begin = 0.0;        ///< [s]
  double end = 0.0;          ///< [s]
  double cast_length = 0.0;  ///< [m] at the end
  double depth = 0.0;        ///< [m] of the metal at the end
};

Course course_of(const Case& casting_case);

/// The values a table takes in the course: at both ends of its range and at its points between.
/// @param curve  against time [s] or cast length [m]; of other tables all values
/// @return       in the unit of the curve
std::vector<double> values_in(const Curve& curve, const Course& course);

/// Whether a table is never entered: all of its points lie on one side of what the course comes
/// through, so that one value holds from beginning to end. Not so of constants and of tables
/// against anything but time and cast length.
/// @param shift  [s] by which a table against time comes later
bool never_reached(const Curve& curve, const Course& course, double shift = 0.0);

/// Joins texts, of many the first ones: "a, b, c and 12 more".
std::string listed(const std::vector<std::string>& texts);

}  // namespace dccast::casting
