#include "server/jobs/socket_path.hpp"

#include <fcntl.h>
#include <sys/un.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <string_view>
#include <system_error>

namespace dccast::jobs {

namespace {

const std::string unix_scheme = "unix:";

/// Whether no character of a path has a meaning of its own in an address: "%41" is "A" there.
bool is_plain(const std::string& path) {
  return std::ranges::all_of(path, [](unsigned char each) {
    return std::isalnum(each) != 0 || std::string_view("/._-").find(each) != std::string_view::npos;
  });
}

bool fits(const std::string& path) {
  return path.size() < sizeof(sockaddr_un::sun_path);
}

}  // namespace

SocketPath::SocketPath(const std::string& address) : address_(address) {
  if (!address.starts_with(unix_scheme) || (fits(path()) && is_plain(path()))) return;
  const std::filesystem::path folder = path().parent_path();
  folder_ = storage::FileDescriptor(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
  if (!folder_)
    throw std::system_error(errno, std::generic_category(), "cannot open " + folder.string());
  address_ = unix_scheme + "/proc/self/fd/" + std::to_string(folder_.get()) + "/" +
             path().filename().string();
}

std::filesystem::path SocketPath::path() const {
  return address_.starts_with(unix_scheme) ? address_.substr(unix_scheme.size()) : "";
}

}  // namespace dccast::jobs
