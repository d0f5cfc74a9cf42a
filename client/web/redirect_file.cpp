#include "client/web/redirect_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <string.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <system_error>

#include "client/session/failure.hpp"

namespace dccast::client {
namespace {

namespace fs = std::filesystem;

/// The user's runtime directory, which is in memory and emptied at logout; else that of temporary
/// files.
fs::path private_folder() {
  const char* const runtime = std::getenv("XDG_RUNTIME_DIR");
  const bool is_usable = runtime != nullptr && ::access(runtime, W_OK | X_OK) == 0;
  return is_usable ? fs::path(runtime) : fs::temp_directory_path();
}

[[noreturn]] void fail(const std::string& path) {
  throw CommandFailed(ExitCode::not_found,
                      fmt::format("--open: cannot write {}: {}; open the printed address", path,
                                  ::strerror(errno)));
}

}  // namespace

RedirectFile::RedirectFile(const std::string& address) {
  std::string folder = private_folder() / "dccast-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) fail(folder);
  folder_ = folder;

  const std::string page = fmt::format(
      "<!DOCTYPE html>\n<meta charset=\"utf-8\">\n<title>dccast</title>\n"
      "<meta name=\"referrer\" content=\"no-referrer\">\n"
      "<meta http-equiv=\"refresh\" content=\"0; url={}\">\n",
      address);
  // The address holds a key: in a file of the user others cannot read it, on the command line of
  // the browser they could.
  const int file = ::open(path().c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool is_written =
      file >= 0 && ::write(file, page.data(), page.size()) == static_cast<ssize_t>(page.size());
  if (file >= 0) ::close(file);
  if (is_written) return;
  const int error = errno;
  remove();
  errno = error;
  fail(path());
}

void RedirectFile::remove() {
  std::error_code ignored;  // the system clears the folder some day
  fs::remove_all(folder_, ignored);
}

}  // namespace dccast::client
