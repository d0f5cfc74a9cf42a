#pragma once

#include <system_error>

/// Which errors of the system are no fault of what was being done: it can be done again later.
namespace dccast::storage {

/// The disk refuses: it is full, fails or is mounted read-only, or a quota or a limit is reached.
bool is_disk_fault(const std::error_code& code);

/// A disk fault, or this process or machine is short of descriptors or memory.
bool is_resource_fault(const std::error_code& code);

}  // namespace dccast::storage
