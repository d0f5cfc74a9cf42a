#include "proto/case_file/key_place.hpp"

#include <charconv>

#include "proto/case_file/schema.hpp"
#include "proto/case_file/toml_walker.hpp"

namespace dccast::case_file {
namespace {

std::optional<Segment> parse_segment(std::string_view text) {
  const std::size_t bracket = text.find('[');
  Segment segment{std::string(text.substr(0, bracket)), std::nullopt};
  if (segment.key.empty()) return std::nullopt;
  if (bracket == std::string_view::npos) return segment;
  const char* const end = text.data() + text.size();
  const auto [read, error] =
      std::from_chars(text.data() + bracket + 1, end, segment.element.emplace());
  if (error != std::errc{} || read + 1 != end || *read != ']') return std::nullopt;
  return segment;
}

/// The field at a path.
struct Place {
  const Message* message = nullptr;
  const FieldDescriptor* field = nullptr;
  std::optional<std::size_t> element;
};

Place find_place(const Message& root, std::string_view path) {
  const std::vector<Segment> segments = segments_of(path);
  const Message* message = &root;
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Reflection& reflection = *message->GetReflection();
    const auto& [key, element] = segments[i];
    const FieldDescriptor* const field = field_of_key(*message->GetDescriptor(), key);
    if (field == nullptr) return {};

    if (i + 1 == segments.size()) return {message, field, element};
    if (is_curve(*field) && i + 2 == segments.size())
      return {message, recipe_field(*field, segments[i + 1].key), std::nullopt};

    // Continues with the table that the segment names.
    if (!is_table(*field)) return {};
    if (!field->is_repeated()) {
      message = &reflection.GetMessage(*message, field);
    } else {
      const auto count = static_cast<std::size_t>(reflection.FieldSize(*message, field));
      if (!element || *element >= count) return {};
      message = &reflection.GetRepeatedMessage(*message, field, static_cast<int>(*element));
    }
  }
  return {};
}

/// The number of KEY.scale or KEY.offset that leaves the key unchanged: 1 or 0.
std::optional<double> neutral_number(const Message& message, std::string_view path) {
  for (const auto& [suffix, number] :
       {std::pair(std::string_view(".scale"), 1.0), std::pair(std::string_view(".offset"), 0.0)})
    if (path.ends_with(suffix) &&
        has_value_at(message, path.substr(0, path.size() - suffix.size())))
      return number;
  return std::nullopt;
}

}  // namespace

std::vector<Segment> segments_of(std::string_view path) {
  std::vector<Segment> segments;
  for (std::size_t begin = 0; begin <= path.size();) {
    const std::size_t end = std::min(path.find('.', begin), path.size());
    auto segment = parse_segment(path.substr(begin, end - begin));
    if (!segment) return {};
    segments.push_back(std::move(*segment));
    begin = end + 1;
  }
  return segments;
}

const FieldDescriptor* field_at(const Message& message, std::string_view path) {
  return find_place(message, path).field;
}

bool has_value_at(const Message& message, std::string_view path) {
  const Place place = find_place(message, path);
  return place.field != nullptr && is_present(*place.message, *place.field);
}

std::optional<double> number_at(const Message& message, std::string_view path) {
  const auto [owner, field, element] = find_place(message, path);
  if (field == nullptr) return neutral_number(message, path);
  if (!is_curve(*field)) return number_of(*owner, *field);

  const v1::Curve curve = curve_of(*owner, *field);
  const auto count = static_cast<std::size_t>(curve.value_size());
  if (element ? *element >= count : count != 1) return std::nullopt;
  return curve.value(static_cast<int>(element.value_or(0)));
}

bool is_whole_number(const Message& message, std::string_view path) {
  const FieldDescriptor* const field = field_at(message, path);
  return field != nullptr && (field->cpp_type() == FieldDescriptor::CPPTYPE_INT32 ||
                              field->cpp_type() == FieldDescriptor::CPPTYPE_INT64);
}

}  // namespace dccast::case_file
