// Conditions on the bottom block.
#include <fmt/format.h>

#include <algorithm>

#include "core/casting/case/checks.hpp"
#include "core/mesh/base.hpp"
#include "core/mesh/plan_file.hpp"

namespace dccast::casting {

namespace {

/// A hole that a plane of symmetry cuts beside its centre would not be round.
void check_symmetry_of_hole(CaseFindings& found, const std::string& field, double centre,
                            double diameter) {
  if (centre <= length_round_off || centre >= 0.5 * diameter - length_round_off) return;
  found.fault(field, with_unit(centre, "m"),
              "lies so near the plane of symmetry that it cuts the hole",
              "0 m, or at least half the diameter, " + with_unit(0.5 * diameter, "m"),
              "move the hole onto the plane, or away from it");
}

/// Distance from the centre of a hole to the edge of the block [m]: to that of the plan, whether it
/// is built in or from a file; of an imported mesh to its end.
double distance_from_edge(CaseFindings& found, const thermal::DrainHole& hole) {
  const mesh::SectionSpec& s = found.casting.section;
  const auto& imported = std::get<std::optional<mesh::Mesh3D>>(found.imported);
  if (imported) return std::min(imported->largest(0) - hole.x, imported->largest(1) - hole.y);

  return mesh::distance_from_edge(s, found.plan ? *found.plan : found.built_in_plan(), hole.x,
                                  hole.y);
}

/// Smallest depth of a piecewise linear profile over the slab [m].
double least_depth(const Curve& profile, double length) {
  if (profile.empty()) return 0.0;
  double least = std::min(profile(0.0), profile(length));
  for (std::size_t i = 0; i < profile.at().size(); ++i)
    if (profile.at()[i] < length) least = std::min(least, profile.value()[i]);
  return least;
}

}  // namespace

void check_gap_water(CaseFindings& found) {
  const thermal::CoolingSpec& cooling = found.casting.cooling;
  const thermal::BottomBlock& block = cooling.bottom_block;
  if (!block.gap_water) return;

  if (block.wet_coefficient)
    found.fault("cooling.bottom_block.gap_water", "given",
                "and cooling.bottom_block.wet_coefficient is given beside it",
                "one law of the water under the butt", "leave one of them out");

  // The gap gets what the marched film of a face has left.
  for (const thermal::Face face : {thermal::Face::wide, thermal::Face::narrow}) {
    if (cooling.water_of(face).boiling_follows_flow) continue;
    found.fault("cooling.bottom_block.gap_water", "given",
                "needs water whose flow and temperature at the edge of the butt are known",
                "with boiling_follows_flow = true on every face",
                "set boiling_follows_flow, or use wet_coefficient");
    return;
  }
}

void check_bowl(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  if (!s.bowl || !found.sound({"section.half_width", "section.half_thickness"})) return;

  if (mesh::has_mesh_file(s))
    found.fault("cooling.bottom_block.bowl", "given",
                "has no effect: the bottom of mesh.file is the surface of the block",
                "absent with mesh.file", "leave it out, and mesh the bowl");

  // The cells over a steeper wall would be too oblique.
  if (s.bowl->wall < s.bowl->depth)
    found.fault("cooling.bottom_block.bowl.wall", with_unit(s.bowl->wall, "m"),
                "is narrower than the bowl is deep",
                fmt::format("at least {}", with_unit(s.bowl->depth, "m")),
                "widen the wall, or make the bowl less deep");

  const double half =
      found.solid() ? std::min(s.half_width, s.half_thickness(s.half_width)) : s.half_width;
  if (s.bowl->lip + s.bowl->wall > half)
    found.fault("cooling.bottom_block.bowl.wall", with_unit(s.bowl->wall, "m"),
                "does not fit between the lip and the middle of the block",
                fmt::format("at most {}", with_unit(std::max(0.0, half - s.bowl->lip), "m")),
                "make the wall or the lip narrower");
}

void check_drain_holes(CaseFindings& found) {
  const thermal::BottomBlock& block = found.casting.cooling.bottom_block;
  if (block.drain_holes.empty()) return;

  if (!found.solid()) return quarter_slab_only(found, "cooling.bottom_block.drain_hole", true);
  if (!block.gap_water)
    found.fault("cooling.bottom_block.drain_hole", "given",
                "has no effect: no water with a flow gets into the gap",
                "with the table cooling.bottom_block.gap_water",
                "add this table in place of wet_coefficient, or leave the holes out");

  for (std::size_t i = 0; i < block.drain_holes.size(); ++i) {
    const thermal::DrainHole& hole = block.drain_holes[i];
    const std::string field = fmt::format("cooling.bottom_block.drain_hole[{}]", i);
    if (!found.sound({field})) continue;
    check_symmetry_of_hole(found, field + ".x", hole.x, hole.diameter);
    check_symmetry_of_hole(found, field + ".y", hole.y, hole.diameter);

    if (!found.sound(plan_keys) || !found.sound({"mesh.file"})) continue;
    const double inward = distance_from_edge(found, hole);
    if (inward < 0.5 * hole.diameter - length_round_off)
      found.fault(field,
                  fmt::format("x = {}, y = {}", with_unit(hole.x, "m"), with_unit(hole.y, "m")),
                  "does not lie in the block",
                  fmt::format("a centre at least half the diameter, {}, from the edge of the block",
                              with_unit(0.5 * hole.diameter, "m")),
                  "move the hole inwards, or make it smaller");
  }
}

void check_block_profile(CaseFindings& found) {
  const mesh::SectionSpec& s = found.casting.section;
  const thermal::BottomBlock& block = found.casting.cooling.bottom_block;
  if (block.profile_x.empty() && block.profile_y.empty()) return;
  if (!found.sound({"section.half_width", "section.half_thickness",
                    "cooling.bottom_block.profile_x", "cooling.bottom_block.profile_y"}))
    return;

  // The slab must rest on the block somewhere, since depths are measured from the contact.
  const double along_x = least_depth(block.profile_x, s.half_width);
  const double along_y = found.solid() ? least_depth(block.profile_y, s.half_thickness(0.0)) : 0.0;
  if (along_x + along_y <= length_round_off) return;

  const bool of_x = along_x > length_round_off;
  found.fault(of_x ? "cooling.bottom_block.profile_x" : "cooling.bottom_block.profile_y",
              with_unit(of_x ? along_x : along_y, "m"),
              "is the least depth of the block: the slab would touch it nowhere",
              "0 m somewhere under the slab", "subtract this depth from every value of the table");
}

}  // namespace dccast::casting
