#pragma once

#include <sys/socket.h>

#include <optional>

namespace dccast::relay {

/// The user of this machine who has the other end of a TCP connection over loopback. The system
/// knows whose socket that is.
/// @param client  address of the other end
/// @param server  address of our end
/// @return        user id; nothing where the system does not know
std::optional<unsigned> owner_of_socket(const sockaddr_storage& client,
                                        const sockaddr_storage& server);

}  // namespace dccast::relay
