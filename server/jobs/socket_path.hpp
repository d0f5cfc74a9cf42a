#pragma once

#include <filesystem>
#include <string>

#include "core/storage/file_descriptor.hpp"

namespace dccast::jobs {

/// The address of a Unix socket in a form that system and gRPC take, whatever its path is: the
/// address of a socket holds some hundred bytes, and gRPC reads it as a URI. A path that is longer
/// or has special characters is replaced by one through a descriptor of the socket's folder, good
/// within this process, as long as this lives.
class SocketPath {
public:
  /// @param address  "unix:" and a path; any other address stays as it is
  /// @throws std::system_error  the folder of such a path cannot be opened
  explicit SocketPath(const std::string& address);
  const std::string& address() const { return address_; }
  /// Without "unix:".
  std::filesystem::path path() const;

private:
  storage::FileDescriptor folder_;
  std::string address_;
};

}  // namespace dccast::jobs
