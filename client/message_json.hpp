#pragma once

#include <google/protobuf/message.h>
#include <nlohmann/json.hpp>

namespace dccast::client {

using Json = nlohmann::ordered_json;

/// A message of the schema as JSON for scripts: names as in the .proto files (they carry the
/// units), whole numbers as numbers, enums by name, times in RFC 3339, NaN and infinity as null.
/// Absent messages and optional numbers are left out; everything else is present even if empty.
Json to_json(const google::protobuf::Message& message);

}  // namespace dccast::client
