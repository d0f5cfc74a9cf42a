#pragma once

#include <string>
#include <string_view>

namespace dccast::values {

/// A random UUID (version 4) in lower case: the id of a job, of a study, of a submission that may
/// have to be repeated.
std::string random_uuid();

/// Whether `text` is a UUID in lower case, as random_uuid() writes them. Everything else is refused
/// before it comes near a path or a statement.
bool is_uuid(std::string_view text);

}  // namespace dccast::values
