#pragma once

#include <sys/socket.h>

#include <optional>

namespace dccast::relay {

/// User who owns the other end of a connection over a Unix socket, or over TCP on loopback; the
/// kernel is asked for the owner of that socket.
/// @param socket  this end
/// @param client  address of the other end
/// @return        user id; empty if the kernel does not know
std::optional<unsigned> owner_of_peer(int socket, const sockaddr_storage& client);

}  // namespace dccast::relay
