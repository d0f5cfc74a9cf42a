#include "client/session/private_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <iterator>
#include <system_error>

namespace dccast::client {

std::string write_private_file(const std::filesystem::path& file, const std::string& text) {
  std::error_code error;
  std::filesystem::create_directories(file.parent_path(), error);
  const std::string part = file.string() + ".part";
  ::unlink(part.c_str());

  const int descriptor = ::open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool written = descriptor >= 0 &&
                       ::write(descriptor, text.data(), text.size()) == std::ssize(text) &&
                       ::fsync(descriptor) == 0;

  const int reason = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (written && ::rename(part.c_str(), file.c_str()) == 0) return {};
  const std::string why = std::strerror(written ? errno : reason);
  ::unlink(part.c_str());
  return why;
}

}  // namespace dccast::client
