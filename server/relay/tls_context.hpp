#pragma once

#include <openssl/ssl.h>

#include <array>
#include <cstdint>
#include <memory>
#include <string>

namespace dccast::relay {

/// Where the server's certificate stands.
struct TlsFiles {
  std::string certificate, key;  ///< PEM
  std::string client_ca;         ///< PEM; empty: certificates of clients are not asked for
};

/// Settings of OpenSSL for new connections, made anew when the files change: connections that are
/// open keep theirs.
class TlsContext {
public:
  /// @throws std::runtime_error  the files cannot be used
  explicit TlsContext(TlsFiles files);

  SSL_CTX& get() const { return *context_; }

  /// Takes the files up where they have changed. Files that do not fit each other are tried again
  /// at the next call: whoever renews them replaces one after the other.
  void refresh();

private:
  using Context = std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)>;
  struct Version {
    std::uint64_t inode = 0;
    std::int64_t modified_ns = 0, size = -1;
    bool operator==(const Version&) const = default;
  };
  using Versions = std::array<Version, 3>;
  static Version version_of(const std::string& file);
  Versions versions() const;
  Context load() const;

  const TlsFiles files_;
  Versions loaded_, refused_{};
  Context context_;
};

}  // namespace dccast::relay
