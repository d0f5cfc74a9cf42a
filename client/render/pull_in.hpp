#pragma once

#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// How far the wide face of a quarter slab has left the mould's wall at one height.
struct PullIn {
  std::string name;                      ///< "butt", "middle", "head"
  double height_m = 0.0;                 ///< in the undeformed slab
  std::vector<double> x_m;               ///< from the middle of the wide face, rising
  std::vector<double> mould_m;           ///< half the opening of the mould there
  std::vector<double> half_thickness_m;  ///< of the slab there

  double pull_in_m(std::size_t i) const { return mould_m[i] - half_thickness_m[i]; }
  double percent(std::size_t i) const { return 100.0 * pull_in_m(i) / mould_m[i]; }
};

/// At the butt (the lowest row), at the head (the greatest height at which the wide face is solid
/// over its whole length; of a slab without one, the metal level) and half way between them.
/// @return  empty for a frame without displacements in three dimensions
std::vector<PullIn> pull_in_profiles(const v1::Frame& frame);

/// Chart of the profiles [mm] as inline SVG.
std::string pull_in_chart(const std::vector<PullIn>& profiles);

/// The profiles at the middle, half way and end of the wide face, in mm and %, as an HTML table.
std::string pull_in_table(const std::vector<PullIn>& profiles);

}  // namespace dccast::client::render
