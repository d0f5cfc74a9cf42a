#include "server/relay/tls_context.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/err.h>
#include <sys/stat.h>

#include <stdexcept>
#include <utility>

#include "core/storage/file.hpp"
#include "server/jobs/log.hpp"

namespace dccast::relay {

namespace {

/// The one application protocol of gRPC, as ALPN writes it: length, then name.
constexpr std::array<unsigned char, 3> http2{2, 'h', '2'};

int choose_http2(SSL*, const unsigned char** chosen, unsigned char* size,
                 const unsigned char* offered, unsigned int offered_size, void*) {
  unsigned char* found = nullptr;
  if (::SSL_select_next_proto(&found, size, http2.data(), http2.size(), offered, offered_size) !=
      OPENSSL_NPN_NEGOTIATED)
    return SSL_TLSEXT_ERR_ALERT_FATAL;
  *chosen = found;
  return SSL_TLSEXT_ERR_OK;
}

/// The first reason that OpenSSL gives.
std::string reason() {
  const unsigned long error = ::ERR_get_error();
  const char* text = error == 0 ? nullptr : ::ERR_reason_error_string(error);
  ::ERR_clear_error();
  return text == nullptr ? "unknown error" : text;
}

void require(int result, const std::string& file) {
  if (result != 1) throw std::runtime_error(fmt::format("cannot use {}: {}", file, reason()));
}

void set_policy(SSL_CTX& context) {
  ::SSL_CTX_set_min_proto_version(&context, TLS1_2_VERSION);
  ::SSL_CTX_set_cipher_list(&context, "ECDHE+AESGCM:ECDHE+CHACHA20");
  ::SSL_CTX_set_alpn_select_cb(&context, &choose_http2, nullptr);

  // Each connection proves anew who the client is: nothing is resumed.
  ::SSL_CTX_set_options(&context, SSL_OP_NO_TICKET | SSL_OP_NO_RENEGOTIATION |
                                      SSL_OP_NO_COMPRESSION | SSL_OP_CIPHER_SERVER_PREFERENCE);
  ::SSL_CTX_set_session_cache_mode(&context, SSL_SESS_CACHE_OFF);
  ::SSL_CTX_set_num_tickets(&context, 0);

  // Idle connections hold no buffers.
  ::SSL_CTX_set_mode(&context, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER |
                                   SSL_MODE_RELEASE_BUFFERS);
  // A read returns after a record that carries no content, such as a renewal of keys.
  ::SSL_CTX_clear_mode(&context, SSL_MODE_AUTO_RETRY);
}

}  // namespace

TlsContext::TlsContext(TlsFiles files)
    : files_(std::move(files)), loaded_(versions()), context_(load()) {}

TlsContext::Version TlsContext::version_of(const std::string& file) {
  struct stat status;
  if (file.empty() || ::stat(file.c_str(), &status) != 0) return {};
  constexpr std::int64_t ns_per_s = 1'000'000'000;
  return {status.st_ino, status.st_mtim.tv_sec * ns_per_s + status.st_mtim.tv_nsec, status.st_size};
}

TlsContext::Versions TlsContext::versions() const {
  return {version_of(files_.certificate), version_of(files_.key), version_of(files_.client_ca)};
}

TlsContext::Context TlsContext::load() const {
  // OpenSSL would wait for the writer of a named pipe.
  for (const std::string& file : {files_.certificate, files_.key, files_.client_ca})
    if (!file.empty()) storage::File(file, O_RDONLY, storage::owner_only, storage::Links::follow);

  ::ERR_clear_error();
  Context context(::SSL_CTX_new(::TLS_server_method()), &::SSL_CTX_free);
  if (!context) throw std::runtime_error(fmt::format("OpenSSL cannot begin: {}", reason()));
  set_policy(*context);

  require(::SSL_CTX_use_certificate_chain_file(context.get(), files_.certificate.c_str()),
          files_.certificate);
  require(::SSL_CTX_use_PrivateKey_file(context.get(), files_.key.c_str(), SSL_FILETYPE_PEM),
          files_.key);
  require(::SSL_CTX_check_private_key(context.get()), files_.key);

  if (!files_.client_ca.empty()) {
    require(::SSL_CTX_load_verify_file(context.get(), files_.client_ca.c_str()), files_.client_ca);
    ::SSL_CTX_set_client_CA_list(context.get(),
                                 ::SSL_load_client_CA_file(files_.client_ca.c_str()));
    // One who shows no certificate may have a token; one who shows a wrong one is refused.
    ::SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, nullptr);
  }
  return context;
}

void TlsContext::refresh() {
  const Versions now = versions();
  if (now == loaded_) return;
  try {
    context_ = load();
    loaded_ = now;
    log::info("certificate {} was renewed and is used for new connections", files_.certificate);
  } catch (const std::runtime_error& error) {
    if (now != refused_) log::warn("the certificate was not renewed: {}", error.what());
    refused_ = now;
  }
}

}  // namespace dccast::relay
