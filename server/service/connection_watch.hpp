#pragma once

#include <sys/types.h>

#include <atomic>
#include <cstddef>
#include <memory>
#include <string>

namespace dccast::service {

/// Connections of one listener that were ended for what their clients sent.
using EndedConnections = std::shared_ptr<std::atomic<int>>;

/// The socket that a descriptor stands for now; 0: none. Once a descriptor is closed it may be
/// another's.
ino_t socket_behind(int descriptor);

/// From now on what gRPC reads from this connection passes a FrameGuard, and the connection is
/// ended when that asks for it.
///
/// gRPC 1.51 shows nothing of a connection but its calls, and those when they have cost their
/// memory already. Its source reads by `recvmsg` and `SSL_read` alone; the program's own functions
/// of these names stand before those of the C library and OpenSSL, as the linker's rules have it,
/// look at what was read, and copy nothing.
/// @param connection  descriptor of a socket
/// @param peer        the client as gRPC writes it
/// @param over_tls    its frames are what SSL_read returns
/// @param ended       counts one when the connection is ended so
void watch_connection(int connection, const std::string& peer, bool over_tls,
                      EndedConnections ended);

/// The client whose bytes the calling thread has read last; empty: none. gRPC looks at the headers
/// of a call in the turn in which it reads them.
std::string peer_read_last();

/// How much all requests together may hold that are not finished [bytes]. Beyond, the connection
/// that holds most is ended.
void bound_unfinished_requests(std::size_t most);

}  // namespace dccast::service
