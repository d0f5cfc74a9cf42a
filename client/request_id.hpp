#pragma once

#include <string>

namespace dccast::client {

/// A random UUID (version 4), so that a submit that is repeated gives one job only.
std::string make_request_id();

}  // namespace dccast::client
