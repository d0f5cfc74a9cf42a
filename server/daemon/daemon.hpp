#pragma once

#include <signal.h>

#include <iosfwd>
#include <string>
#include <vector>

#include "dccast/v1/config.pb.h"
#include "server/daemon/settings.hpp"

namespace dccast::daemon {

/// SIGTERM, SIGINT and SIGUSR1.
sigset_t awaited_signals();

/// Serves until one of these signals arrives; they must be blocked in all threads. @return 0
/// @throws std::runtime_error  the address or the data directory cannot be used
int serve(const v1::DaemonConfig& config, const WorkerPolicy& workers);

/// Changes or shows users, certificates or the audit log of a data directory, also while a daemon
/// uses it. @throws access::Refused, storage::StorageError
void administrate(const AdministrationCommand& command, const v1::DaemonConfig& config,
                  std::ostream& out);

/// The files of TLS, from the settings or from the daemon's own CA.
struct TlsFiles {
  std::string certificate, key, ca, client_ca;  ///< PEM; client_ca may be empty
  bool own = false;                             ///< of the daemon's own CA
};

/// Creates CA and certificate if the settings name none and none exist, and renews an own
/// certificate that ends within a month. @throws access::Refused, storage::StorageError
TlsFiles prepare_tls(const v1::DaemonConfig& config);

/// What will keep clients from logging in: a certificate of another CA, or for another name; each a
/// sentence with the remedy. @throws access::Refused, storage::StorageError
std::vector<std::string> tls_faults(const v1::DaemonConfig& config, const TlsFiles& files);

/// What keeps dccastd from serving with these settings besides what read_config() refuses; each a
/// sentence with the remedy. Creates nothing.
std::vector<std::string> faults_beside_settings(const v1::DaemonConfig& config);

}  // namespace dccast::daemon
