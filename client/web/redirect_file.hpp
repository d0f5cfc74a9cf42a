#pragma once

#include <filesystem>
#include <string>

namespace dccast::client {

/// A page on disk, readable by its user alone, that sends a browser to an address. Arguments of a
/// program can be read by every user of the machine; an address with a key must not be one.
class RedirectFile {
public:
  /// Writes it to $XDG_RUNTIME_DIR, else to the folder for temporary files.
  /// @throws CommandFailed  it cannot be written
  explicit RedirectFile(const std::string& address);
  /// Removes page and folder.
  ~RedirectFile() { remove(); }
  RedirectFile(const RedirectFile&) = delete;

  std::string path() const { return folder_ / "dashboard.html"; }
  /// Its address has been used, or never will be. Any number of times, from any thread.
  void remove();

private:
  std::filesystem::path folder_;  // of its own, mode 0700
};

}  // namespace dccast::client
