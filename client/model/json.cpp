#include "client/model/json.hpp"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include <fmt/format.h>
#include <google/protobuf/message.h>
#include <google/protobuf/timestamp.pb.h>
#include <google/protobuf/util/time_util.h>
#include <nlohmann/json.hpp>

namespace dccast::client {

/// Converts to the tree of the library that knows how to write texts and numbers.
struct JsonWriter {
  using Tree = nlohmann::ordered_json;

  Tree operator()(std::monostate) const { return nullptr; }
  Tree operator()(const Json::Array& elements) const {
    Tree tree = Tree::array();
    for (const Json& element : elements) tree.push_back(tree_of(element));
    return tree;
  }
  Tree operator()(const Json::Object& members) const {
    Tree tree = Tree::object();
    for (const auto& [key, value] : members) tree[key] = tree_of(value);
    return tree;
  }
  Tree operator()(const auto& value) const { return value; }

  static Tree tree_of(const Json& json) { return std::visit(JsonWriter(), json.value_); }
  /// Whether this is {"key", value}.
  static bool is_member(const Json& json) {
    const auto* const pair = std::get_if<Json::Array>(&json.value_);
    return pair && pair->size() == 2 && std::holds_alternative<std::string>(pair->front().value_);
  }
};

Json::Json(std::initializer_list<Json> elements) {
  if (!std::all_of(elements.begin(), elements.end(), JsonWriter::is_member)) {
    value_ = Array(elements);
    return;
  }
  Object& members = value_.emplace<Object>();
  for (const Json& element : elements) {
    const Array& pair = std::get<Array>(element.value_);
    members.emplace_back(std::get<std::string>(pair.front().value_), pair.back());
  }
}

Json Json::object() {
  Json json;
  json.value_ = Object();
  return json;
}

Json& Json::push_back(Json element) {
  if (value_.index() == 0) value_ = Array();
  return std::get<Array>(value_).emplace_back(std::move(element));
}

Json& Json::operator[](const std::string& key) {
  if (value_.index() == 0) value_ = Object();
  Object& members = std::get<Object>(value_);
  for (auto& [name, value] : members)
    if (name == key) return value;
  return members.emplace_back(key, Json()).second;
}

std::string Json::dump() const {
  return JsonWriter::tree_of(*this).dump(-1, ' ', false,
                                         JsonWriter::Tree::error_handler_t::replace);
}

namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;
using google::protobuf::Reflection;

/// States of studies are spelt as those of jobs: a prefix keeps them apart in the schema only.
std::string enum_name(const google::protobuf::EnumValueDescriptor& value) {
  constexpr std::string_view prefix = "STUDY_";
  const bool prefixed = value.type()->name() == "StudyState" && value.name().starts_with(prefix);
  return prefixed ? value.name().substr(prefix.size()) : value.name();
}

Json single(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  switch (field.cpp_type()) {
    case FieldDescriptor::CPPTYPE_MESSAGE:
      return to_json(reflection.GetMessage(message, &field));
    case FieldDescriptor::CPPTYPE_ENUM:
      return enum_name(*reflection.GetEnum(message, &field));
    case FieldDescriptor::CPPTYPE_BOOL:
      return reflection.GetBool(message, &field);
    case FieldDescriptor::CPPTYPE_DOUBLE:
      return reflection.GetDouble(message, &field);
    case FieldDescriptor::CPPTYPE_INT32:
      return reflection.GetInt32(message, &field);
    case FieldDescriptor::CPPTYPE_INT64:
      return reflection.GetInt64(message, &field);
    case FieldDescriptor::CPPTYPE_STRING:
      return reflection.GetString(message, &field);
    default:
      return nullptr;
  }
}

Json repeated(const Message& message, const FieldDescriptor& field) {
  const Reflection& reflection = *message.GetReflection();
  Json list = Json::array();
  for (int i = 0; i < reflection.FieldSize(message, &field); ++i)
    if (field.cpp_type() == FieldDescriptor::CPPTYPE_MESSAGE)
      list.push_back(to_json(reflection.GetRepeatedMessage(message, &field, i)));
    else if (field.cpp_type() == FieldDescriptor::CPPTYPE_DOUBLE)
      list.push_back(reflection.GetRepeatedDouble(message, &field, i));
    else if (field.cpp_type() == FieldDescriptor::CPPTYPE_INT32)
      list.push_back(reflection.GetRepeatedInt32(message, &field, i));
    else if (field.cpp_type() == FieldDescriptor::CPPTYPE_STRING)
      list.push_back(reflection.GetRepeatedString(message, &field, i));
  return list;
}

/// Python and others write NaN and infinities, which JSON does not have: here they become texts.
std::string with_quoted_words(const std::string& text) {
  constexpr std::array<std::string_view, 3> words{"NaN", "-Infinity", "Infinity"};
  std::string quoted;
  bool in_text = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = std::string_view(text).substr(i);
    const auto word = std::ranges::find_if(
        words, [rest](std::string_view each) { return rest.starts_with(each); });
    if (!in_text && word != words.end()) {
      quoted += fmt::format("\"{}\"", *word);
      i += word->size() - 1;
      continue;
    }

    if (text[i] == '"') in_text = !in_text;
    quoted += text[i];
    // What a backslash protects neither begins nor ends a text.
    if (in_text && text[i] == '\\' && i + 1 < text.size()) quoted += text[++i];
  }
  return quoted;
}

}  // namespace

Json to_json(const Message& message) {
  if (const auto* time = dynamic_cast<const google::protobuf::Timestamp*>(&message))
    return google::protobuf::util::TimeUtil::ToString(*time);
  Json object = Json::object();
  const auto& descriptor = *message.GetDescriptor();
  for (int i = 0; i < descriptor.field_count(); ++i) {
    const FieldDescriptor& field = *descriptor.field(i);
    if (field.is_repeated())
      object[field.name()] = repeated(message, field);
    else if (!field.has_presence() || message.GetReflection()->HasField(message, &field))
      object[field.name()] = single(message, field);
  }
  return object;
}

ObjectMembers members_of_object(const std::string& text) {
  ObjectMembers read;
  std::set<std::string> names;
  const auto look = [&](int depth, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    if (event != nlohmann::json::parse_event_t::key || depth != 1) return true;
    const std::string& name = parsed.get_ref<const std::string&>();
    if (!names.insert(name).second && read.twice.empty()) read.twice = name;
    return true;
  };
  const auto object = nlohmann::json::parse(with_quoted_words(text), look, false);
  if (!object.is_object()) return {};

  // No column is a list or an object; a remark can still name what stood there.
  auto& members = read.members.emplace();
  for (const auto& [name, member] : object.items()) {
    std::string& value = members[name];
    if (member.is_string())
      value = member.get<std::string>();
    else if (member.is_structured())
      value = member.is_object() ? "{...}" : "[...]";
    else if (!member.is_null())
      value = member.dump();
  }
  return read;
}

}  // namespace dccast::client
