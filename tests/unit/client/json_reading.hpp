#pragma once

#include <nlohmann/json.hpp>

namespace dccast::client {

/// Values that a script reads from the output of a command.
using ReadJson = nlohmann::ordered_json;

}  // namespace dccast::client
