#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "core/storage/file.hpp"
#include "dccast/v1/access.pb.h"

namespace dccast::access {

/// The audit log: audit.log of the data directory, its owner's alone. One line of JSON an event,
/// appended by one write(), so that the daemon and a command can both write; nothing in it is ever
/// changed. It is on the disk when the system writes it there: a crash of the machine may cost its
/// last seconds, one of the daemon nothing. Safe to use from several threads.
class AuditLog {
public:
  /// @param directory  the data directory @throws storage::StorageError
  explicit AuditLog(const std::filesystem::path& directory);
  /// The time is set here. @throws storage::StorageError
  void append(v1::AuditEvent event);

private:
  const storage::File file_;
};

/// Which events are wanted; empty texts: all.
struct AuditFilter {
  std::string user{}, job{}, call{};
  std::string since{};  ///< the beginning of an RFC 3339 time, inclusive
};

/// Prints the lines that pass, as they stand. @return their number
/// @throws storage::StorageError  there is no log
std::size_t print_audit(const std::filesystem::path& directory, const AuditFilter& filter,
                        std::ostream& out);

}  // namespace dccast::access
