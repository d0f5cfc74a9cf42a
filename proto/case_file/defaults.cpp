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

/// A message with nothing but the default of one field, by the reader itself: a default is written
/// as in a file. Kept, since a text for each key costs more than a whole file.
const Message& default_of(const FieldDescriptor& field, const Message& message) {
  static std::mutex mutex;
  static std::map<const FieldDescriptor*, std::unique_ptr<const Message>> kept;
  const std::lock_guard lock(mutex);
  if (const auto found = kept.find(&field); found != kept.end()) return *found->second;
  std::unique_ptr<Message> read(message.New());
  const std::string& text = key_of(field).default_text();
  const ReadOutcome outcome = read_text(toml_key(field) + " = " + text, "default", *read);
  // The text holds one key only, so required ones are missing by design.
  for (const v1::Fault& fault : outcome.faults)
    if (fault.field().starts_with(toml_key(field)) && fault.message() != "required key is missing")
      throw std::logic_error("default of " + field.full_name() + ": " + fault.message());
  return *kept.emplace(&field, std::move(read)).first->second;
}

void set_default(Message& message, const FieldDescriptor& field) {
  const std::string& text = key_of(field).default_text();
  if (text.empty() || text == "\"\"" || text == by_quality) return;
  message.MergeFrom(default_of(field, message));
}

/// A creep law is there or not; an empty one must not appear by itself.
bool appears_by_itself(const FieldDescriptor& field) {
  return !key_of(field).only_if_given() &&
         field.containing_type()->full_name() != v1::Alloy::descriptor()->full_name();
}

void apply(Message& message, bool alloy_inside) {
  const Reflection& reflection = *message.GetReflection();
  for (const FieldDescriptor* const field : fields_of(*message.GetDescriptor())) {
    if (!is_table(*field)) {
      if (!is_present(message, *field) && (!alloy_inside || field->name() == "card"))
        set_default(message, *field);
    } else if (field->is_repeated()) {
      for (int i = 0; i < reflection.FieldSize(message, field); ++i)
        apply(*reflection.MutableRepeatedMessage(&message, field, i), is_alloy(*field));
    } else if (appears_by_itself(*field) || is_present(message, *field)) {
      apply(*reflection.MutableMessage(&message, field), is_alloy(*field));
    }
  }
}

/// The block's place in the mould gives the depth of the metal. @pre the defaults of `cooling`
void apply_block_place(v1::Case& c) {
  v1::Section& section = *c.mutable_section();
  if (section.has_block_above_water_m() && !section.has_initial_depth_m())
    section.set_initial_depth_m(c.cooling().water().from_m() - section.block_above_water_m());
}

}  // namespace

void apply_defaults(Message& message) {
  if (auto* description = dynamic_cast<v1::Case*>(&message)) {
    apply(*description->mutable_cooling(), false);
    apply_block_place(*description);
    apply_quality(*description);
  }
  apply(message, false);
}

}  // namespace dccast::case_file
