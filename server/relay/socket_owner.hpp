#pragma once

#include <sys/socket.h>

#include <optional>

namespace dccast::relay {

/// The user of this machine who has the other end of a connection, of a Unix socket or of TCP over
/// loopback. The system knows whose socket that is.
/// @param socket  our end
/// @param client  address of the other end
/// @return        user id; nothing where the system does not know
std::optional<unsigned> owner_of_peer(int socket, const sockaddr_storage& client);

}  // namespace dccast::relay
