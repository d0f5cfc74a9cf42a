#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>

#include <toml++/toml.h>

#include "dccast/v1/case.pb.h"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// A message that contains only the default of one field. A default is written as in a file and
/// parsed by the reader. The messages are cached, because parsing one text per key takes longer
/// than parsing a whole file.
const Message& default_message(const FieldDescriptor& field, const Message& message) {
  static std::mutex mutex;
  static std::map<const FieldDescriptor*, std::unique_ptr<const Message>> cached;
  const std::lock_guard lock(mutex);
  if (const auto found = cached.find(&field); found != cached.end()) return *found->second;

  std::unique_ptr<Message> read(message.New());
  const std::string& text = key_of(field).default_text();
  const ReadOutcome outcome =
      read_text(fmt::format("{} = {}", toml_key(field), text), "default", *read);

  // The text contains one key only, so required ones are missing by design.
  const auto is_missing = [&outcome](const v1::Fault& fault) {
    return std::ranges::find(outcome.missing_keys, fault.field()) != outcome.missing_keys.end();
  };
  for (const v1::Fault& fault : outcome.faults)
    if (fault.field().starts_with(toml_key(field)) && !is_missing(fault))
      throw std::logic_error(fmt::format("default of {}: {}", field.full_name(), fault.message()));

  return *cached.emplace(&field, std::move(read)).first->second;
}

void set_default(Message& message, const FieldDescriptor& field) {
  const std::string& text = key_of(field).default_text();
  if (text.empty() || text == "\"\"" || text == by_quality) return;
  message.MergeFrom(default_message(field, message));
}

/// Whether a table is created for its defaults if it is absent. A creep law is not: an empty one
/// would count as given.
bool is_created_for_defaults(const FieldDescriptor& field) {
  return !key_of(field).only_if_given() &&
         field.containing_type()->full_name() != v1::Alloy::descriptor()->full_name();
}

/// The keys of a message that are filled.
enum class Fill {
  all_keys,
  card_only  ///< of an alloy inside another message: a default must not hide the value of its card
};

Fill nested_fill(const FieldDescriptor& field) {
  return is_alloy(field) ? Fill::card_only : Fill::all_keys;
}

void apply(Message& message, Fill fill) {
  const Reflection& reflection = *message.GetReflection();

  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    if (!is_table(*field)) {
      if (!is_present(message, *field) && (fill == Fill::all_keys || field->name() == "card"))
        set_default(message, *field);
    } else if (field->is_repeated()) {
      for (int i = 0; i < reflection.FieldSize(message, field); ++i)
        apply(*reflection.MutableRepeatedMessage(&message, field, i), nested_fill(*field));
    } else if (is_created_for_defaults(*field) || is_present(message, *field)) {
      apply(*reflection.MutableMessage(&message, field), nested_fill(*field));
    }
  }
}

/// Computes the depth of the metal from the position of the block in the mould.
/// @pre the defaults of `cooling` are filled
void apply_block_place(v1::Case& c) {
  v1::Section& section = *c.mutable_section();
  if (section.has_block_above_water_m() && !section.has_initial_depth_m())
    section.set_initial_depth_m(c.cooling().water().from_m() - section.block_above_water_m());
}

/// Mechanics begins with the shell that exists when the mould is full.
void apply_start_of_mechanics(v1::Case& description) {
  v1::Mechanics& mechanics = *description.mutable_mechanics();
  if (mechanics.has_start_s()) return;
  const v1::Schedule& schedule = description.schedule();
  const bool filled = schedule.filling_s() > 0.0;
  mechanics.set_start_s(filled ? schedule.filling_s() - schedule.hold_s() : 0.0);
}

}  // namespace

void apply_defaults(Message& message) {
  if (auto* description = dynamic_cast<v1::Case*>(&message)) {
    apply(*description->mutable_cooling(), Fill::all_keys);
    apply_block_place(*description);
    apply_start_of_mechanics(*description);
    apply_quality(*description);
  }
  apply(message, Fill::all_keys);
}

}  // namespace dccast::case_file
