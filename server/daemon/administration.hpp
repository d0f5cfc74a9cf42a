#pragma once

#include <iosfwd>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"
#include "server/access/audit.hpp"

namespace dccast::daemon {

/// What `dccastd user`, `pki` and `audit` are asked for.
struct AdministrationCommand {
  std::string verb;  ///< "user add", "pki show", "audit"
  std::string name;  ///< of a user
  std::string role = "submitter";
  std::string directory;  ///< of pki issue
  std::vector<std::string>
      names;                   ///< of pki init and renew; empty: those of before, or this machine's
  int days = 0;                ///< 0: as usual
  access::AuditFilter filter;  ///< of audit
};

/// Changes or shows users, certificates or the audit log of a data directory, whether a daemon uses
/// it or not. @throws access::Refused, storage::StorageError
void administrate(const AdministrationCommand& command, const v1::DaemonConfig& config,
                  std::ostream& out);

/// The files of TLS, by the settings or from the daemon's own CA.
struct TlsFiles {
  std::string certificate, key, ca, client_ca;  ///< PEM; client_ca may be empty
  bool own = false;                             ///< of the daemon's own CA
};

/// Makes CA and certificate where the settings name none and there are none yet, and renews a
/// certificate of our own that ends within a month. @throws access::Refused, storage::StorageError
TlsFiles prepare_tls(const v1::DaemonConfig& config);

}  // namespace dccast::daemon
