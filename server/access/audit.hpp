#pragma once

#include <filesystem>
#include <iosfwd>
#include <string>

#include "core/storage/file.hpp"
#include "dccast/v1/access.pb.h"

namespace dccast::access {

/// The audit log, audit.log of the data directory; only its owner can read it. Each event is a line
/// of JSON, appended by one write(), so that the daemon and a command can both write. Lines are
/// never changed. The file is not synced: a crash of the machine may lose the last seconds, a crash
/// of the daemon nothing. Safe to use from several threads.
class AuditLog {
public:
  /// @param directory  the data directory @throws storage::StorageError
  explicit AuditLog(const std::filesystem::path& directory);
  /// Appends an event with the present time. @throws storage::StorageError
  void append(v1::AuditEvent event);

private:
  storage::File open() const;

  const std::filesystem::path path_;
};

/// Selects events; empty texts: all.
struct AuditFilter {
  std::string user{}, job{}, call{};
  std::string since{};  ///< earliest time; a prefix of an RFC 3339 time
};

/// Prints the selected lines unchanged. @return their number
/// @throws storage::StorageError  there is no log
std::size_t print_audit(const std::filesystem::path& directory, const AuditFilter& filter,
                        std::ostream& out);

}  // namespace dccast::access
