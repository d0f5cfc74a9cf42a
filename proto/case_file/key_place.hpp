#pragma once

#include <google/protobuf/message.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

/// Paths of keys as in a case file: "schedule.casting_speed", "monitor[1].x",
/// "schedule.water_flow.scale".
namespace dccast::case_file {

/// One part of a path: a key, and the index if it is an element of a list.
struct Segment {
  /// Path of a key, and the index of a point where it names one.
  std::string key;
  std::optional<std::size_t> element;
};

/// The parts of a path; empty if the text is not a path.
std::vector<Segment> segments_of(std::string_view path);

/// The field at a path of a message; null if there is no such key or element.
const google::protobuf::FieldDescriptor* field_at(const google::protobuf::Message& message,
                                                  std::string_view path);

/// Whether there is a value at a path.
bool has_value_at(const google::protobuf::Message& message, std::string_view path);

/// The number at a path: the value of a quantity, a number, an integer, a curve of one point, or
/// one point of a curve; for "KEY.scale" and "KEY.offset" the number that leaves the key unchanged.
/// @return [unit of the schema]; empty for other keys and absent ones
std::optional<double> number_at(const google::protobuf::Message& message, std::string_view path);

/// Whether the key at this path takes whole numbers only.
bool is_whole_number(const google::protobuf::Message& message, std::string_view path);

}  // namespace dccast::case_file
