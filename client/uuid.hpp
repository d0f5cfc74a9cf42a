#pragma once

#include <string>

namespace dccast::client {

/// A random UUID (version 4): the request id of a submission that may have to be repeated, or the
/// name of a study.
std::string make_uuid();

}  // namespace dccast::client
