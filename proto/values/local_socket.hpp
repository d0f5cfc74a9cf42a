#pragma once

#include <optional>
#include <string>

/// The Unix sockets at which a daemon serves the users of its own machine.
namespace dccast::values {

/// Of the service of a machine; its folder is the service manager's.
inline constexpr const char* service_socket = "/run/dccast/dccastd.sock";

/// Where a daemon started now is to listen: in the runtime directory that the service manager gives
/// it ($RUNTIME_DIRECTORY), else in that of its user ($XDG_RUNTIME_DIR).
/// @return nothing: there is no such directory, or the path is too long for a socket
std::optional<std::string> own_socket();

/// Whether a program listens at this path.
bool is_listening(const std::string& path);

/// The server of this machine: "unix:PATH" of the daemon of this user, else of the service, where
/// one listens; else loopback without a port.
std::string local_server();

}  // namespace dccast::values
