#pragma once

#include <istream>
#include <string>
#include <vector>

#include "dccast/v1/study.pb.h"

namespace dccast::client {

/// What a file of measurements holds.
struct MeasuredFile {
  /// One for each column after the first.
  std::vector<v1::MeasuredCurve> curves;
  std::vector<std::string> faults;  ///< "curl.csv:3:2: ..." with what is permitted; empty: none
};

/// Reads measurements of one casting: comma, semicolon or tab between columns, a point in numbers,
/// "#" before comments. The first line names the columns with their units; the first is the time or
/// the cast length of the readings, each further one a monitor whose unit decides what was
/// measured:
///
///     time [s], curl corner [mm], thermocouple [degC]
///     10,       4.1,              612
///
/// "curl", "gap", "temperature" before a monitor may be left out. An empty cell is no reading.
/// @param name      of the file, in faults and as the source of the curves
/// @param monitors  of the case
MeasuredFile read_measured(std::istream& stream, const std::string& name,
                           const std::vector<std::string>& monitors);

}  // namespace dccast::client
