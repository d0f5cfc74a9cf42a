#pragma once

#include <string>
#include <vector>

#include "client/model/comparison.hpp"

namespace dccast::client {

/// A figure that differed between two runs before their curls did.
struct Cause {
  std::string figure;    ///< "heat through the wide face"
  std::string unit;      ///< of the values below, as shown
  std::string sentence;  ///< "less heat through the wide face until 100 s (-22 %)"
  double onset = 0.0;    ///< place of the course where the difference begins [s] or [m]
  double share = 0.0;    ///< mean difference until the curls differ, of the figure's own scale [1]
  std::vector<double> first, other;  ///< (place of the course) [`unit`]
};

/// What the histories show of why two curls differ: up to three figures, those that differ most
/// relative to their own scale, in the order in which they begin to differ.
///
/// A figure counts only if it differs, on average up to the place where nine tenths of the
/// difference have come about, by more than 3 % of its scale, and begins to before half of the
/// difference has. That is what was different first; the runs cannot show more.
std::vector<Cause> causes_of(const Answer& first, const Answer& other,
                             const CurlDifference& difference);

/// "corner: -11.8 ± 1.0 mm, real. Less heat through the wide face until 100 s (-22 %), ...". Causes
/// are named for differences that are not within their error.
/// @param explained  causes were looked for: if there are none, the sentence says so
std::string sentence(const CurlDifference& difference, const std::vector<Cause>& causes,
                     bool explained = true);

}  // namespace dccast::client
