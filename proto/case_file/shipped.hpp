#pragma once

#include <algorithm>
#include <string>
#include <vector>

/// Case files and alloy cards that are built into the programs, so that they work from anywhere.
namespace dccast::shipped {

/// A text that was embedded at build time.
struct ShippedText {
  std::string name;  ///< file name without `.toml`, e.g. "start-2d-thickness"
  std::string text;  ///< the whole file
};

/// The files of cases/, by name.
const std::vector<ShippedText>& case_templates();

/// The files of cases/alloys/, by name.
const std::vector<ShippedText>& alloy_cards();

/// The text with this name; null if there is none.
inline const ShippedText* find(const std::vector<ShippedText>& texts, const std::string& name) {
  const auto found = std::ranges::find(texts, name, &ShippedText::name);
  return found == texts.end() ? nullptr : &*found;
}

/// Names of the texts, in their order.
inline std::vector<std::string> names_of(const std::vector<ShippedText>& texts) {
  std::vector<std::string> names;
  for (const ShippedText& text : texts) names.push_back(text.name);
  return names;
}

}  // namespace dccast::shipped
