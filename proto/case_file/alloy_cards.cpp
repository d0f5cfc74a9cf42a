#include "proto/case_file/alloy_cards.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "proto/case_file/case_file.hpp"
#include "proto/case_file/key_place.hpp"
#include "proto/case_file/quantity.hpp"
#include "proto/case_file/schema.hpp"
#include "proto/case_file/shipped.hpp"
#include "proto/case_file/text_checks.hpp"
#include "proto/case_file/uncertainty.hpp"

namespace dccast::case_file {
namespace {

/// Whether a name is permitted: it cannot lead outside its folder.
bool is_plain_name(const std::string& name) {
  constexpr const char* permitted =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-.";
  return !name.empty() && name.size() <= 100 && name.front() != '.' &&
         name.find_first_not_of(permitted) == std::string::npos;
}

/// The fault of a card that does not exist, with the known names.
AlloyCard unknown_card(const std::string& name, const std::filesystem::path& directory) {
  const std::vector<std::string> names = alloy_names(directory);
  const std::string near = nearest(name, names);
  return {{},
          {make_fault("alloy.card", quoted(name.substr(0, 100)), "unknown alloy", joined(names),
                      near.empty()
                          ? "see `dccast alloys`; your own card is a path, as \"./my-alloy.toml\""
                          : fmt::format("did you mean \"{}\"?", near))}};
}

/// The card under its name, with its faults as faults of the case.
AlloyCard named_card(const std::string& name, AlloyCard card, ReadOutcome read) {
  card.alloy.set_card(name);
  card.faults = read.ok() ? uncertainty_faults(card.alloy) : std::move(read.faults);
  for (v1::Fault& fault : card.faults) {
    // The message already has value, range and remedy.
    v1::Fault of_case;
    of_case.set_field("alloy.card");
    of_case.set_value(quoted(name));
    of_case.set_message(fmt::format("in alloy card {}", describe(fault, read.source)));
    fault = std::move(of_case);
  }
  return card;
}

/// Clears the curves that another message gives: merging would append their points.
void clear_curves_given_in(const google::protobuf::Message& given,
                           google::protobuf::Message& message) {
  for (const FieldDescriptor* const field : fields_of(*given.GetDescriptor()))
    if (is_curve(*field) && is_present(given, *field))
      message.GetReflection()->ClearField(&message, field);
}

}  // namespace

AlloyCard alloy_card(const std::string& name, const std::filesystem::path& directory) {
  if (!is_plain_name(name)) return unknown_card(name, directory);

  AlloyCard card;
  ReadOutcome read;
  std::error_code error;
  const std::filesystem::path file = directory / (name + ".toml");
  if (!directory.empty() && std::filesystem::is_regular_file(file, error))
    read = read_file(file, card.alloy);
  else if (const auto* const shipped = shipped::find(shipped::alloy_cards(), name))
    read = read_text(shipped->text, name + ".toml", card.alloy);
  else
    return unknown_card(name, directory);

  return named_card(name, std::move(card), std::move(read));
}

AlloyCard own_card(const std::string& name, std::string_view text) {
  AlloyCard card;
  ReadOutcome read = read_elsewhere(text, name, card.alloy);
  return named_card(name, std::move(card), std::move(read));
}

std::vector<std::string> alloy_names(const std::filesystem::path& directory) {
  std::set<std::string> names;
  for (const auto& shipped : shipped::alloy_cards()) names.insert(shipped.name);
  std::error_code error;
  if (!directory.empty())
    for (const auto& entry : std::filesystem::directory_iterator(directory, error))
      if (entry.path().extension() == ".toml" && is_plain_name(entry.path().stem().string()))
        names.insert(entry.path().stem().string());
  return {names.begin(), names.end()};
}

void replace_data(const v1::Alloy& data, v1::Alloy& card) {
  // Two keys for the same property exclude each other: the one given replaces that of the card.
  if (data.has_coherency_c()) card.clear_coherency_solid_fraction();
  if (data.has_coherency_solid_fraction()) card.clear_coherency_c();
  if (data.has_density_kg_per_m3()) {
    card.clear_solid_density_kg_per_m3();
    card.clear_liquid_density_kg_per_m3();
  }
  if (data.has_conductivity_w_per_m_k()) {
    card.clear_solid_conductivity_w_per_m_k();
    card.clear_liquid_conductivity_w_per_m_k();
  }
  if (data.has_melt_conductivity_factor()) card.clear_melt_stirring();
  if (data.has_melt_stirring()) card.clear_melt_conductivity_factor();

  clear_curves_given_in(data, card);
  if (data.has_cold_strength())
    clear_curves_given_in(data.cold_strength(), *card.mutable_cold_strength());

  card.MergeFrom(data);
}

void complete_alloy(const v1::Alloy& card, v1::Alloy& overrides) {
  v1::Alloy complete = card;
  if (overrides.has_norton_hoff() && !card.has_norton_hoff()) complete.clear_reference_creep();
  if (overrides.has_reference_creep() && !card.has_reference_creep()) complete.clear_norton_hoff();

  // The range of the card does not hold for a value of the case.
  complete.clear_uncertainty();
  for (const v1::KeyRange& line : card.uncertainty())
    if (!has_value_at(overrides, line.key())) *complete.add_uncertainty() = line;

  replace_data(overrides, complete);
  apply_defaults(complete);
  overrides = std::move(complete);
}

}  // namespace dccast::case_file
