#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::case_file {

/// An alloy card and its faults.
struct AlloyCard {
  v1::Alloy alloy;                ///< as in its file, without defaults
  std::vector<v1::Fault> faults;  ///< faults of the file; a missing card is one fault

  /// Whether the card can be used.
  bool ok() const { return faults.empty(); }
};

/// Loads the card `name` from `directory/name.toml` if this file exists, else from the shipped
/// cards. An unknown name is a fault of "alloy.card" that lists the known names and the most
/// similar one. Names may only contain letters, digits, '_', '-' and '.', so that a name never
/// refers to a file outside the folder.
AlloyCard alloy_card(const std::string& name, const std::filesystem::path& directory = {});

/// Reads a card that travels with its case. @param name  of its file, which becomes the card's name
AlloyCard own_card(const std::string& name, std::string_view text);

/// Names of all cards, shipped ones and those of `directory`, sorted.
std::vector<std::string> alloy_names(const std::filesystem::path& directory = {});

/// Puts data into a card. Curves are replaced as a whole; the rivals of a key that the data have,
/// as the pair of densities beside one density, go.
void replace_data(const v1::Alloy& data, v1::Alloy& card);

/// Completes the alloy of a case: keys given in `overrides` are kept, missing ones are taken from
/// the card, and keys that both lack get their default. Curves are replaced as a whole. The two
/// creep laws exclude each other: if the case gives the other law, that of the card is dropped; if
/// it gives some constants of the card's law, the others are kept.
void complete_alloy(const v1::Alloy& card, v1::Alloy& overrides);

}  // namespace dccast::case_file
