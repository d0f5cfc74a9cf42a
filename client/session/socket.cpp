#include "client/session/socket.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netdb.h>
#include <openssl/pem.h>
#include <poll.h>
#include <signal.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <array>
#include <cerrno>

namespace dccast::client {
namespace {

using Bio = values::Owned<BIO, BIO_free>;
using Certificate = values::Owned<X509, X509_free>;

/// Connects within the time limit. @return 0 or the system's error
int connect_within(int descriptor, const addrinfo& to, std::chrono::milliseconds timeout) {
  const int flags = ::fcntl(descriptor, F_GETFL);
  ::fcntl(descriptor, F_SETFL, flags | O_NONBLOCK);
  // A blocking connect() would wait for minutes where packets are dropped.
  if (::connect(descriptor, to.ai_addr, to.ai_addrlen) != 0) {
    if (errno != EINPROGRESS) return errno;
    pollfd waiting{descriptor, POLLOUT, 0};
    if (::poll(&waiting, 1, static_cast<int>(timeout.count())) != 1) return ETIMEDOUT;
    int error = 0;
    socklen_t size = sizeof error;
    ::getsockopt(descriptor, SOL_SOCKET, SO_ERROR, &error, &size);
    if (error != 0) return error;
  }
  ::fcntl(descriptor, F_SETFL, flags);
  const timeval limit{timeout.count() / 1000, (timeout.count() % 1000) * 1000};
  ::setsockopt(descriptor, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  ::setsockopt(descriptor, SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
  return 0;
}

Socket::Outcome outcome_of(int error) {
  switch (error) {
    case ECONNREFUSED:
      return Socket::Outcome::refused;
    case ETIMEDOUT:
      return Socket::Outcome::timed_out;
    case EHOSTUNREACH:
    case ENETUNREACH:
      return Socket::Outcome::no_route;
    default:
      return Socket::Outcome::failed;
  }
}

bool is_number(const std::string& host) {
  std::array<unsigned char, 16> bytes;
  return ::inet_pton(AF_INET, host.c_str(), bytes.data()) == 1 ||
         ::inet_pton(AF_INET6, host.c_str(), bytes.data()) == 1;
}

Certificate parse(const std::string& pem) {
  const Bio bio(BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
  return Certificate(PEM_read_bio_X509(bio.get(), nullptr, nullptr, nullptr));
}

}  // namespace

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

Socket::~Socket() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Socket::Socket(const values::HostAndPort& to, std::chrono::milliseconds timeout) {
  addrinfo hints{};
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* all = nullptr;
  if (const int error = ::getaddrinfo(to.host.c_str(), to.port.c_str(), &hints, &all)) {
    outcome_ = Outcome::no_name;
    reason_ = ::gai_strerror(error);
    return;
  }

  int error = 0;
  for (const addrinfo* one = all; one != nullptr; one = one->ai_next) {
    const int tried = ::socket(one->ai_family, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const int failed = tried < 0 ? errno : connect_within(tried, *one, timeout);
    if (failed == 0) {
      descriptor_ = tried;
      break;
    }
    if (error == 0) error = failed;  // the first is the cause
    if (tried >= 0) ::close(tried);
  }

  ::freeaddrinfo(all);
  if (is_connected()) return;
  outcome_ = outcome_of(error);
  reason_ = ::strerror(error);
}

std::string Socket::exchange(const std::string& sent) {
  std::array<char, 64> bytes;
  if (::send(descriptor_, sent.data(), sent.size(), MSG_NOSIGNAL) < 0) return "";
  const auto size = ::recv(descriptor_, bytes.data(), bytes.size(), 0);
  return size > 0 ? std::string(bytes.data(), static_cast<std::size_t>(size)) : "";
}

const std::string http2_greeting("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n\0\0\0\4\0\0\0\0\0", 33);

Speaks language_of(const std::string& answer) {
  if (answer.empty()) return Speaks::nothing;
  if (answer.starts_with("HTTP/1") || answer.starts_with("<")) return Speaks::http1;
  if (answer[0] == 0x15 || answer[0] == 0x16) return Speaks::tls;
  return answer.size() >= 9 && answer[0] == 0 && answer[3] == 4 ? Speaks::http2
                                                                : Speaks::something_else;
}

Handshake::Handshake(const Socket& socket, const values::HostAndPort& to, const std::string& ca)
    : context(SSL_CTX_new(TLS_client_method())), session(nullptr) {
  SSL_CTX_set_verify(context.get(), SSL_VERIFY_PEER, [](int, X509_STORE_CTX*) { return 1; });
  if (const Certificate trusted = ca.empty() ? nullptr : parse(ca))
    X509_STORE_add_cert(SSL_CTX_get_cert_store(context.get()), trusted.get());

  session.reset(SSL_new(context.get()));
  constexpr std::array<unsigned char, 3> http2{2, 'h', '2'};
  SSL_set_alpn_protos(session.get(), http2.data(), http2.size());
  if (is_number(to.host)) {
    X509_VERIFY_PARAM_set1_ip_asc(SSL_get0_param(session.get()), to.host.c_str());
  } else {
    SSL_set_tlsext_host_name(session.get(), to.host.c_str());
    SSL_set1_host(session.get(), to.host.c_str());
  }

  SSL_set_fd(session.get(), socket.descriptor());
  // OpenSSL writes to a connection that the other side may have closed.
  const auto before = ::signal(SIGPIPE, SIG_IGN);
  made = SSL_connect(session.get()) == 1;
  ::signal(SIGPIPE, before);
}

}  // namespace dccast::client
