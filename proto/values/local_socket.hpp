#pragma once

#include <string>

/// The Unix sockets at which a daemon serves the users of its own machine.
namespace dccast::values {

/// Beginning of the address of a Unix socket; the path follows.
inline constexpr const char* unix_scheme = "unix:";

/// Socket of the system's service, in the folder that systemd makes for it.
inline constexpr const char* service_socket = "/run/dccast/dccastd.sock";

/// Path of a daemon's socket by default: in $RUNTIME_DIRECTORY, which systemd gives a service, else
/// in $XDG_RUNTIME_DIR of its user, else in a folder of this user in /tmp, which is made if
/// necessary.
/// @throws std::runtime_error  that folder cannot be made, or others may write there
std::string default_socket_path();

/// Whether a program listens at this path.
bool is_listening(const std::string& path);

/// Address of the server of this machine, "unix:PATH": the daemon of this user if it listens, else
/// the service if that listens, else where the daemon of this user would listen.
std::string local_server();

}  // namespace dccast::values
