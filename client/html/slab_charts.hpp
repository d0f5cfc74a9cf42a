#pragma once

#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"

namespace dccast::client::render {

/// The bottom of a quarter slab in plan, coloured by its distance from the block, as inline SVG.
struct GapMap {
  std::string svg;   ///< empty if the frame has no 3D bottom
  int contacts = 0;  ///< number of bottom nodes in contact with the block
  double largest_gap_m = 0.0;
  double largest_x_m = 0.0, largest_y_m = 0.0;  ///< its place in the undeformed slab [m]
};

/// Plan view, x to the right and y up; dots mark nodes in contact, larger dots carry more load.
GapMap draw_gap_map(const v1::Frame& frame);

/// Distance between mould wall and wide face of a quarter slab at one height.
struct PullIn {
  std::string name;                      ///< "butt", "middle", "head"
  double height_m = 0.0;                 ///< in the undeformed slab [m]
  std::vector<double> x_m;               ///< from the middle of the wide face, ascending [m]
  std::vector<double> mould_m;           ///< half the opening of the mould there [m]
  std::vector<double> half_thickness_m;  ///< of the slab there [m]

  /// Half opening of the mould minus half thickness, positive where the slab has pulled in.
  double pull_in_m(std::size_t i) const { return mould_m[i] - half_thickness_m[i]; }
  double percent(std::size_t i) const { return 100.0 * pull_in_m(i) / mould_m[i]; }
};

/// Profiles at the butt (frames::butt_height_m above the block, as dccast contraction), at the head
/// (the greatest height at which the wide face is solid over its whole length, or else the metal
/// level) and half way between them.
/// @return  empty for a frame without 3D displacements
std::vector<PullIn> pull_in_profiles(const v1::Frame& frame);

/// Chart of the profiles [mm] as inline SVG.
std::string pull_in_chart(const std::vector<PullIn>& profiles);

/// The profiles at the middle, half way and end of the wide face, in mm and %, as an HTML table.
std::string pull_in_table(const std::vector<PullIn>& profiles);

}  // namespace dccast::client::render
