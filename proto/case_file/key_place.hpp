#pragma once

#include <google/protobuf/message.h>

#include <optional>
#include <string_view>

namespace dccast::case_file {

/// The field at a path of a message, as in a case file ("schedule.casting_speed", "monitor[1].x",
/// "schedule.water_flow.scale").
struct FieldPlace {
  google::protobuf::Message* message = nullptr;
  const google::protobuf::FieldDescriptor* field = nullptr;  ///< null: there is no such key
};

/// Missing tables on the path are created, elements of arrays are not.
FieldPlace place_of(google::protobuf::Message& message, std::string_view path);

/// Whether a value stands at this path.
bool has_value_at(const google::protobuf::Message& message, std::string_view path);

/// The number at a path: the value of a quantity, a number, an integer, a curve of one point, one
/// point of a curve; of "KEY.scale" and "KEY.offset" what leaves the key as it is.
/// @return [unit of the schema]; empty for other keys and absent ones
std::optional<double> number_at(const google::protobuf::Message& message, std::string_view path);

/// Whether the key at this path takes whole numbers only.
bool is_whole_number(const google::protobuf::Message& message, std::string_view path);

}  // namespace dccast::case_file
