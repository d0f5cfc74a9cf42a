#include "proto/case_file/size_bounds.hpp"

#include "proto/case_file/quantity.hpp"
#include "proto/values/printable.hpp"
#include "proto/values/shortened.hpp"

namespace dccast::case_file {
namespace {

/// A description may have lines; a title or a name stands in lists and logs.
values::Lines lines_of(const FieldDescriptor& field) {
  constexpr int longest_line = 255;
  return key_of(field).maximum_length() > longest_line ? values::Lines::several
                                                       : values::Lines::one;
}

std::size_t stated_or(std::int32_t stated, std::size_t general) {
  return stated > 0 ? static_cast<std::size_t>(stated) : general;
}

}  // namespace

std::size_t maximum_length(const FieldDescriptor& field) {
  return stated_or(key_of(field).maximum_length(), general_maximum_length);
}

std::size_t maximum_count(const FieldDescriptor& field) {
  return stated_or(key_of(field).maximum_count(), general_maximum_count);
}

std::string size_text(const FieldDescriptor& field) {
  const auto at_most = [](std::size_t number, const char* of) {
    return "at most " + std::to_string(number) + of;
  };
  if (is_curve(field)) return at_most(maximum_count(field), " points");
  if (field.is_repeated()) return at_most(maximum_count(field), " entries");
  if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
    return at_most(maximum_length(field), " bytes");
  return {};
}

std::optional<v1::Fault> text_fault(const FieldDescriptor& field, const std::string& text,
                                    const std::string& path) {
  if (text.size() > maximum_length(field))
    return make_fault(path, quoted(values::shortened(text, maximum_length(field))),
                      "a text of " + std::to_string(text.size()) + " bytes", size_text(field),
                      key_of(field).attachment() ? "rename the file" : "shorten it");
  const auto character = values::unprintable(text, lines_of(field));
  if (!character) return std::nullopt;
  return make_fault(path, quoted(values::escaped(values::shortened(text))),
                    "contains " + *character, "characters that can be shown",
                    "leave that character out");
}

std::optional<v1::Fault> count_fault(const FieldDescriptor& field, std::size_t count,
                                     const std::string& path) {
  if (count <= maximum_count(field)) return std::nullopt;
  const bool curve = is_curve(field);
  return make_fault(path, "", std::to_string(count) + (curve ? " points" : " entries"),
                    size_text(field),
                    curve ? "thin the table out; it is interpolated linearly between points"
                          : "leave some of them out");
}

}  // namespace dccast::case_file
