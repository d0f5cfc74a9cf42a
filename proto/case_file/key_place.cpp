#include "proto/case_file/key_place.hpp"

#include <charconv>
#include <string>

#include "proto/case_file/recipe_words.hpp"
#include "proto/case_file/schema.hpp"

namespace dccast::case_file {
namespace {

/// One part of a path, and the element of an array that it names; -1 for none.
struct Part {
  std::string key;
  int element = -1;
};

Part part_of(std::string_view text) {
  const auto bracket = text.find('[');
  if (bracket == std::string_view::npos) return {std::string(text), -1};
  Part part{std::string(text.substr(0, bracket)), -1};
  std::from_chars(text.data() + bracket + 1, text.data() + text.size(), part.element);
  return part;
}

Message* table_at(Message& message, const FieldDescriptor& field) {
  return message.GetReflection()->MutableMessage(&message, &field);
}

const Message* table_at(const Message& message, const FieldDescriptor& field) {
  return &message.GetReflection()->GetMessage(message, &field);
}

Message* element_at(Message& message, const FieldDescriptor& field, int element) {
  return message.GetReflection()->MutableRepeatedMessage(&message, &field, element);
}

const Message* element_at(const Message& message, const FieldDescriptor& field, int element) {
  return &message.GetReflection()->GetRepeatedMessage(message, &field, element);
}

/// What a path leads to in a message that may be changed, or in one that may only be read.
template <typename AnyMessage>
struct Place {
  AnyMessage* message = nullptr;
  const FieldDescriptor* field = nullptr;
};

template <typename AnyMessage>
Place<AnyMessage> walk(AnyMessage& message, std::string_view path) {
  const auto dot = path.find('.');
  const Part part = part_of(path.substr(0, dot));
  const FieldDescriptor* field = field_of_key(*message.GetDescriptor(), part.key);
  if (field == nullptr) return {};
  if (dot == std::string_view::npos) return {&message, field};
  const std::string_view rest = path.substr(dot + 1);
  if (is_curve(*field)) return {&message, recipe_field(*field, rest)};
  if (field->cpp_type() != FieldDescriptor::CPPTYPE_MESSAGE) return {};
  if (!field->is_repeated()) return walk(*table_at(message, *field), rest);
  if (part.element < 0 || part.element >= message.GetReflection()->FieldSize(message, field))
    return {};
  return walk(*element_at(message, *field, part.element), rest);
}

std::optional<double> scalar(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  if (field.is_repeated() || !is_present(message, field)) return std::nullopt;
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_INT64:
      return static_cast<double>(reflection.GetInt64(message, &field));
    default:
      return std::nullopt;
  }
}

/// What a key is multiplied by, or what is added to it, before it is changed.
std::optional<double> unchanged(const Message& message, std::string_view path) {
  for (const auto& [suffix, number] :
       {std::pair(std::string_view(".scale"), 1.0), std::pair(std::string_view(".offset"), 0.0)}) {
    if (!path.ends_with(suffix)) continue;
    if (has_value_at(message, path.substr(0, path.size() - suffix.size()))) return number;
  }
  return std::nullopt;
}

}  // namespace

FieldPlace place_of(Message& message, std::string_view path) {
  const Place<Message> place = walk(message, path);
  return {place.message, place.field};
}

bool has_value_at(const Message& message, std::string_view path) {
  const auto place = walk(message, path);
  return place.field != nullptr && is_present(*place.message, *place.field);
}

std::optional<double> number_at(const Message& message, std::string_view path) {
  const auto place = walk(message, path);
  if (place.field == nullptr) return unchanged(message, path);
  if (!is_curve(*place.field)) return scalar(*place.message, *place.field);
  v1::Curve curve;
  curve.CopyFrom(place.message->GetReflection()->GetMessage(*place.message, place.field));
  const int point = part_of(path.substr(path.rfind('.') + 1)).element;
  if (point >= 0 && point < curve.value_size()) return curve.value(point);
  if (point >= 0 || curve.value_size() != 1) return std::nullopt;
  return curve.value(0);
}

bool is_whole_number(const Message& message, std::string_view path) {
  const auto place = walk(message, path);
  if (place.field == nullptr) return false;
  return place.field->cpp_type() == FieldDescriptor::CPPTYPE_INT32 ||
         place.field->cpp_type() == FieldDescriptor::CPPTYPE_INT64;
}

}  // namespace dccast::case_file
