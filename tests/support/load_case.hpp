#pragma once

#include <filesystem>
#include <string>

#include "core/casting/case.hpp"

namespace dccast::support {

/// A case file as the service would run it: defaults and alloy card filled in.
/// @param name  path of a file, or name of a shipped case
/// @throws std::runtime_error  with every fault, when it has any
casting::Case load_case(const std::string& name);

}  // namespace dccast::support
