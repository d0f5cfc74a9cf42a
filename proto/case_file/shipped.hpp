#pragma once

#include <string>
#include <vector>

/// Case files and alloy cards that are built into the programs, so that they work from anywhere.
namespace dccast::shipped {

struct ShippedText {
  std::string name;  ///< file name without `.toml`, e.g. "start-2d-thickness"
  std::string text;  ///< the whole file
};

/// The files of cases/, by name.
const std::vector<ShippedText>& case_templates();

/// The files of cases/alloys/, by name.
const std::vector<ShippedText>& alloy_cards();

}  // namespace dccast::shipped
