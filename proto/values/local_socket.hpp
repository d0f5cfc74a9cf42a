#pragma once

#include <string>

/// The Unix sockets at which a daemon serves the users of its own machine.
namespace dccast::values {

/// What an address of a Unix socket begins with; its path follows.
inline constexpr const char* unix_scheme = "unix:";

/// Of the service of a machine; its folder is the service manager's.
inline constexpr const char* service_socket = "/run/dccast/dccastd.sock";

/// Default socket of a daemon: in the runtime directory that the service manager gives it
/// ($RUNTIME_DIRECTORY), else in that of its user ($XDG_RUNTIME_DIR), else in a folder of
/// this user in /tmp, which is made if necessary.
/// @throws std::runtime_error  that folder cannot be made, or others may write there
std::string make_place_of_socket();

/// Whether a program listens at this path.
bool is_listening(const std::string& path);

/// The server of this machine, "unix:PATH": the daemon of this user, else the service, where one
/// listens; else the place of this user's.
std::string local_server();

}  // namespace dccast::values
