#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace google::protobuf {
class Message;
}

namespace dccast::client {

/// A value to be written as JSON; members keep the order in which they were added. The library that
/// writes it stays out of the headers, which half of the client includes.
class Json {
public:
  /// Elements, and members with their names.
  using Array = std::vector<Json>;
  using Object = std::vector<std::pair<std::string, Json>>;

  Json() = default;  ///< null
  Json(std::nullptr_t) {}
  Json(bool value) : value_(value) {}
  template <std::integral Number>
  requires(!std::same_as<Number, bool>) Json(Number value)
      : value_(static_cast<std::int64_t>(value)) {}
  Json(double value) : value_(value) {}  ///< NaN and infinity are written as null
  Json(const char* text) : value_(std::string(text)) {}
  Json(std::string text) : value_(std::move(text)) {}
  template <typename Value>
  Json(const std::optional<Value>& value) : Json(value ? Json(*value) : Json()) {}  ///< empty: null
  template <typename Value>
  Json(const std::vector<Value>& values) : value_(Array(values.begin(), values.end())) {}
  template <typename Value, std::size_t count>
  Json(const std::array<Value, count>& values) : value_(Array(values.begin(), values.end())) {}
  /// An object if every element is a pair of a text and a value, else an array.
  Json(std::initializer_list<Json> elements);

  /// An empty array or object, to which members are added.
  static Json array() { return Json(Array{}); }
  static Json object();

  /// Adds an element; null becomes an array. @return the element
  Json& push_back(Json element);
  /// The member with this key, which is added if there is none; null becomes an object.
  Json& operator[](const std::string& key);

  /// On one line. Bytes that are not UTF-8 are replaced.
  std::string dump() const;

private:
  friend struct JsonWriter;
  std::variant<std::monostate, bool, std::int64_t, double, std::string, Array, Object> value_;
};

/// A message of the schema as JSON for scripts: names as in the .proto files (they carry the
/// units), whole numbers as numbers, enums by name, times in RFC 3339, NaN and infinity as null.
/// Absent messages and optional numbers are left out; everything else is present even if empty.
Json to_json(const google::protobuf::Message& message);

/// A JSON object as its text was read.
struct ObjectMembers {
  /// By name, each as text: a text as it is, null as an empty one, an object or an array as "{...}"
  /// or "[...]". Empty if the text is no complete JSON object.
  std::optional<std::map<std::string, std::string>> members;
  std::string twice;  ///< the first name that is there twice; empty: none
};

/// Reads an object; NaN and Infinity, which are no JSON, are read as texts.
ObjectMembers members_of_object(const std::string& text);

/// An array of element(value) for each value.
template <typename Values, typename Element>
Json json_list(const Values& values, Element element) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(element(value));
  return list;
}

}  // namespace dccast::client
