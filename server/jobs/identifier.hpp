#pragma once

#include <string>
#include <string_view>

namespace dccast::jobs {

/// A random UUID (version 4) in lower case, from the system's random numbers.
std::string random_uuid();

/// Whether `text` is a UUID in lower case, as random_uuid() writes them. Everything else is refused
/// before it comes near a path or a statement.
bool is_uuid(std::string_view text);

/// 256 random bits in hexadecimal: what a worker proves its identity with.
std::string random_token();

}  // namespace dccast::jobs
