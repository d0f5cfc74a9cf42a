#pragma once

#include <optional>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client {

/// Fields of a frame at one point of the metal.
struct PointValues {
  /// Interpolated at the point.
  double temperature_c = 0.0;
  std::vector<double> displacement_m;  ///< (coordinate) [m]; empty if the frame has none
};

/// Interpolates the fields of a frame as its elements do.
/// @param point  (coordinate) [m] in the undeformed slab, as many as the frame has dimensions
/// @return       empty where there is no metal, and for a frame whose arrays are inconsistent
std::optional<PointValues> values_at(const v1::Frame& frame, const std::vector<double>& point);

/// Points from one to another, both included.
/// @param count  at least 2
/// @return       (point, coordinate) [m]
std::vector<std::vector<double>> points_on_line(const std::vector<double>& from,
                                                const std::vector<double>& to, int count);

}  // namespace dccast::client
