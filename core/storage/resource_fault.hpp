#pragma once

#include <system_error>

/// Recognises system errors caused by a temporary lack of resources: the operation can be repeated
/// later.
namespace dccast::storage {

/// The disk is full, failing or mounted read-only, or a quota or a limit is reached.
bool is_disk_fault(const std::error_code& code);

/// A disk fault, or a lack of file descriptors or memory in this process or machine.
bool is_resource_fault(const std::error_code& code);

}  // namespace dccast::storage
