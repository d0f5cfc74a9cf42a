#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "dccast/v1/case.pb.h"
#include "dccast/v1/job.pb.h"

namespace dccast::case_file {

/// An alloy card and what is wrong with it.
struct AlloyCard {
  v1::Alloy alloy;                ///< as its file says, with no defaults
  std::vector<v1::Fault> faults;  ///< of the card's file; a card that cannot be found is one fault

  bool ok() const { return faults.empty(); }
};

/// The card `name` from `directory/name.toml` if there is such a file, else from the shipped ones.
/// An unknown name is a fault on "alloy.card" that lists the known ones and the nearest. Names with
/// anything but letters, digits, '_', '-' and '.' are unknown: a name never leads out of the
/// folder.
AlloyCard alloy_card(const std::string& name, const std::filesystem::path& directory = {});

/// Names of all cards, shipped ones and those of `directory`, sorted.
std::vector<std::string> alloy_names(const std::filesystem::path& directory = {});

/// Puts the card under the case's keys: what `overrides` says stays, what it does not say comes
/// from the card, what neither says gets its default. Curves are replaced as a whole. The two creep
/// laws exclude each other: a case that gives one of them drops the card's other one, and a case
/// that gives some constants of the card's own law keeps the rest of it.
void complete_alloy(const v1::Alloy& card, v1::Alloy& overrides);

}  // namespace dccast::case_file
