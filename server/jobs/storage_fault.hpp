#pragma once

#include <exception>
#include <optional>
#include <string>

namespace dccast::jobs {

/// Whether an error says that the daemon is short of disk, descriptors or memory, which no job is to
/// blame for and which passes. @return what is lacking, in words; nothing for any other error
std::optional<std::string> daemon_lacks(const std::exception& error);

}  // namespace dccast::jobs
