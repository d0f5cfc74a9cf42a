#pragma once

#include <nlohmann/json.hpp>

namespace dccast::client {

/// What a script reads from the output of a command.
using ReadJson = nlohmann::ordered_json;

}  // namespace dccast::client
