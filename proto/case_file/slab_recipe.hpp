#pragma once

#include <string>
#include <vector>

namespace dccast::case_file {

/// The start of a slab, or of a round billet, as a plant names it. Of a range "a..b" the first
/// value holds until the ramp begins, the second one when it has ended.
struct SlabRecipe {
  std::string slab;   ///< both sides, in either order, "1320x570mm"
  std::string alloy;  ///< name of a card, in any case, or a file with one; empty: that of start-3d
  std::string speed;  ///< "45..55mm/min"; empty: that of the shipped case
  std::string water;  ///< "25..45m3/h" in all, or "90..180l/min/m" of perimeter; empty: likewise
  std::string billet{};  ///< in place of `slab`: diameter, "203mm"
};

/// A case file made of the shipped case that is nearest.
struct NewCase {
  /// TOML, with comments that name the origin of each figure.
  std::string text;
  std::string summary;              ///< slab, perimeter, and water in all and per metre
  std::vector<std::string> faults;  ///< of the recipe; then there is no text
};

/// Everything that the recipe does not give is that of the shipped case of the alloy, or of
/// start-3d where the alloy has none; of a billet, that of start-billet. Comments in the text name
/// the origin of each figure.
NewCase new_case(const SlabRecipe& recipe);

}  // namespace dccast::case_file
