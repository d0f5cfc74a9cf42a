#pragma once

#include <openssl/ssl.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace dccast::relay {

/// Paths of the server's TLS files.
struct TlsFiles {
  std::string certificate, key;  ///< PEM
  std::string client_ca;         ///< PEM; empty: client certificates are not requested
};

/// OpenSSL settings for new connections, reloaded when the files change. Open connections keep
/// theirs.
class TlsContext {
public:
  /// @throws std::runtime_error  the files cannot be used
  explicit TlsContext(TlsFiles files);

  SSL_CTX& get() const { return *context_; }

  /// Reloads changed files. Files that do not match are retried at the next call, because a renewal
  /// replaces one after the other.
  void refresh();

private:
  using Context = std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)>;
  /// Properties that change when a file is replaced.
  struct Version {
    std::uint64_t inode = 0;
    std::int64_t modified_ns = 0, size = -1;
    bool operator==(const Version&) const = default;
  };
  using Versions = std::array<Version, 3>;
  /// A file that is missing has size -1.
  static Version version_of(const std::string& file);
  /// Versions of the three files at present.
  Versions versions() const;
  /// Reads the files. @throws std::runtime_error  they cannot be used, or do not match
  Context load() const;

  const TlsFiles files_;
  /// Versions in use, and those that were refused last, so that the log says so once.
  Versions loaded_, refused_{};
  Context context_;
};

}  // namespace dccast::relay
