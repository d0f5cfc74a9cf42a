#include "client/session/servers.hpp"

#include <arpa/inet.h>
#include <fmt/chrono.h>
#include <openssl/bio.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <string_view>

#include "client/session/socket.hpp"
#include "client/session/ssh_tunnel.hpp"
#include "proto/values/digests.hpp"
#include "proto/values/local_socket.hpp"
#include "proto/values/printable.hpp"

namespace dccast::client {
namespace {

/// A proxy of the environment, e.g. "https_proxy=http://proxy:3128"; empty: none.
std::string proxy() {
  for (const char* name : {"https_proxy", "HTTPS_PROXY", "http_proxy", "HTTP_PROXY", "grpc_proxy",
                           "all_proxy", "ALL_PROXY"})
    if (const char* value = std::getenv(name); value != nullptr && *value != '\0')
      return std::string(name) + "=" + values::escaped(value);
  return "";
}

Diagnosis without_connection(const Socket& socket, const values::HostAndPort& to,
                             const ProbeOptions& options) {
  using Outcome = Socket::Outcome;
  const Outcome outcome = socket.outcome();
  const std::string& reason = socket.reason();
  const std::string where = to.host + " port " + to.port;

  if (outcome == Outcome::no_name)
    return {"the name " + to.host + " cannot be resolved (" + reason + ")",
            "check its spelling, or give the address in numbers"};
  if (const std::string through = proxy(); !through.empty())
    return {"there is no direct connection to " + where + " (" + reason +
                "), and dccast never uses a proxy, which the environment names (" + through + ")",
            "ask for a direct way to that port, or go through ssh: --server ssh://" + to.host};
  if (outcome == Outcome::refused)
    return {"the machine answers, but no program listens at " + where,
            "start dccastd there with listen.tls at this port, or give the port that it has (its "
            "log names it)"};
  if (outcome == Outcome::timed_out)
    return {"nothing answers from " + where + " within " +
                std::to_string(double(options.timeout.count()) / 1000.0).substr(0, 4) +
                " s: a firewall drops the connection, or the machine is off",
            "ask for port " + to.port + " to be opened from here to there"};
  if (outcome == Outcome::no_route)
    return {"there is no route to " + where + " (" + reason + ")",
            "check this machine's network or VPN"};
  return {"the connection to " + where + " failed: " + reason, "check the address"};
}

std::string date(const ASN1_TIME* time) {
  tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return utc_text(::timegm(&parts));
}

std::string names_of(X509* certificate) {
  auto* extension = static_cast<GENERAL_NAMES*>(
      X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  std::string names;
  for (int i = 0; i < sk_GENERAL_NAME_num(extension); ++i) {
    const GENERAL_NAME* name = sk_GENERAL_NAME_value(extension, i);

    std::string text;
    if (name->type == GEN_DNS)
      text.assign(reinterpret_cast<const char*>(ASN1_STRING_get0_data(name->d.dNSName)),
                  static_cast<std::size_t>(ASN1_STRING_length(name->d.dNSName)));
    if (name->type == GEN_IPADD) {
      // An address stands as 4 or 16 raw bytes.
      std::array<char, INET6_ADDRSTRLEN> number{};
      ::inet_ntop(ASN1_STRING_length(name->d.iPAddress) == 4 ? AF_INET : AF_INET6,
                  ASN1_STRING_get0_data(name->d.iPAddress), number.data(), number.size());
      text = number.data();
    }

    if (!text.empty()) names += (names.empty() ? "" : ", ") + values::escaped(text);
  }
  GENERAL_NAMES_free(extension);
  return names.empty() ? "none" : names;
}

/// The first fault of the server's certificate for this host and CA.
Diagnosis judge_certificate(SSL* session, const values::HostAndPort& to) {
  const long verdict = SSL_get_verify_result(session);
  X509* shown = SSL_get0_peer_certificate(session);
  if (verdict == X509_V_OK || shown == nullptr) return {};

  switch (verdict) {
    // Its time: the clock of either machine may be wrong.
    case X509_V_ERR_CERT_HAS_EXPIRED:
      return {fmt::format("the server's certificate has expired on {}; this machine's clock has {}",
                          date(X509_get0_notAfter(shown)), utc_text(::time(nullptr))),
              "have it renewed (dccastd pki renew), or set the clock right"};
    case X509_V_ERR_CERT_NOT_YET_VALID:
      return {fmt::format("the server's certificate is not yet valid, but from {} on; this "
                          "machine's clock has {}",
                          date(X509_get0_notBefore(shown)), utc_text(::time(nullptr))),
              "set the clock of this machine right, or wait until then"};

    // Its names.
    case X509_V_ERR_HOSTNAME_MISMATCH:
    case X509_V_ERR_IP_ADDRESS_MISMATCH:
      return {fmt::format("the server's certificate is not for {}, but for {}", to.host,
                          names_of(shown)),
              "use one of these names, or have it renewed for this one: dccastd pki renew --name " +
                  to.host};

    // Its signature: this machine does not trust who made it.
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
    case X509_V_ERR_CERT_SIGNATURE_FAILURE:
      return {
          "the server's certificate is of a CA that is unknown here: another server, a proxy that "
          "reads along, or a CA made anew",
          "ask an admin whether the CA was changed; if so log in again with a new line"};

    default:
      return {std::string("the server's certificate is refused: ") +
                  X509_verify_cert_error_string(verdict),
              "ask an admin to look at `dccastd pki show`"};
  }
}

/// Reason for a missing handshake: the protocol that the server uses instead.
Diagnosis no_handshake(const values::HostAndPort& to, const std::string& address,
                       const ProbeOptions& options) {
  Socket second(to, options.timeout);
  if (!second.is_connected())
    return {"the server at " + address + " ends each connection at once",
            "it may have too many of them; try again later"};

  // The first bytes of the answer show what is spoken in place of TLS.
  switch (language_of(second.exchange(http2_greeting))) {
    case Speaks::http2:
      return {"the server speaks no TLS at " + address +
                  ", without which dccast calls Unix sockets alone",
              "give the port of listen.tls, which the log of dccastd names, or on its own machine "
              "no address"};
    case Speaks::tls:
      return {"the server at " + address + " speaks TLS and refuses this client's greeting",
              "it may be too old, or ask for a certificate: ask an admin"};
    case Speaks::http1:
      return {"a web server without TLS answers at " + address + ", not dccastd",
              "give the port of listen.tls; the log of dccastd names it"};
    case Speaks::nothing:
      return {"the server at " + address + " closes the connection without an answer",
              "it may have too many of them; try again later"};
    default:
      return {"what answers at " + address + " does not speak TLS",
              "give the port of listen.tls; the log of dccastd names it"};
  }
}

Diagnosis secure(const Socket& socket, const values::HostAndPort& to, const Endpoint& endpoint,
                 const ProbeOptions& options, std::vector<std::string>& found) {
  const Handshake hands(socket, to, endpoint.ca);
  if (!hands.made) return no_handshake(to, endpoint.address, options);
  found.push_back(std::string("it speaks ") + SSL_get_version(hands.session.get()));
  if (endpoint.ca.empty())
    return {"the server speaks TLS, and there is no login for " + endpoint.address + " here",
            "log in with the line of `dccastd user add`: dccast login"};
  if (const Diagnosis wrong = judge_certificate(hands.session.get(), to); !wrong.sound())
    return wrong;
  found.push_back("its certificate is good for " + to.host);
  // gRPC needs HTTP/2, which the peer chooses in the handshake (ALPN, "h2").
  const unsigned char* protocol = nullptr;
  unsigned size = 0;
  SSL_get0_alpn_selected(hands.session.get(), &protocol, &size);
  if (size != 2)
    return {"what answers at " + endpoint.address + " speaks TLS, but not HTTP/2",
            "give the port of listen.tls; a proxy in between has to let HTTP/2 through"};
  return {};
}

/// Why a server does not answer who the caller is.
Diagnosis judge_answer(const grpc::Status& status, const ProbeOptions& options) {
  if (status.error_code() == grpc::StatusCode::UNIMPLEMENTED)
    return {fmt::format("the server is of an earlier version than this client, {}, and knows no "
                        "users",
                        options.version),
            "use a client of the server's version"};

  // gRPC refuses a caller who has proved nothing before the service does: its text is all there is.
  if (status.error_code() == grpc::StatusCode::UNAUTHENTICATED)
    return {reason_of(status), "do as the cause says, or log in again"};
  return {"the server does not answer a call: " + reason_of(status), "look into its log"};
}

/// The least role that will do. Every user may read.
v1::Role wanted_role(const ProbeOptions& options) {
  if (options.role.empty() || options.role == "viewer") return v1::ROLE_UNSPECIFIED;
  return options.role == "admin" ? v1::ADMIN : v1::SUBMITTER;
}

/// Makes a call: token, version, role.
Diagnosis call(const Endpoint& endpoint, const ProbeOptions& options,
               std::vector<std::string>& found, std::shared_ptr<Interruption> interruption) {
  Connection connection(endpoint, std::move(interruption));
  v1::WhoAmIResponse who;
  const grpc::Status status = connection.try_once(&Stub::WhoAmI, v1::WhoAmIRequest(), who);
  if (!status.ok()) return judge_answer(status, options);
  found.push_back(fmt::format("you are {}, {}, by {}",
                              who.name().empty() ? "a local user" : who.name(),
                              role_text(who.role()), who.proof()));

  // Versions that differ are the likely cause of what a user sees next, a role that is too low the
  // second.
  v1::GetServerInfoResponse info;
  const bool informed =
      connection.try_once(&Stub::GetServerInfo, v1::GetServerInfoRequest(), info).ok();
  if (informed && !info.worker_sandbox().empty())
    found.push_back("its workers are held by: " + values::escaped(info.worker_sandbox()));
  if (informed && info.version() != options.version)
    return {fmt::format("the server is dccastd {}, and this client is dccast {}", info.version(),
                        options.version),
            "use a client of the server's version"};

  if (who.role() < wanted_role(options))
    return {fmt::format("the role of {} is {}, which is below {}", who.name(),
                        role_text(who.role()), options.role),
            fmt::format("ask an admin: dccastd user role {} {}", who.name(), options.role)};
  return {};
}

/// For a local socket, the file shows why it cannot be used.
Diagnosis at_unix_socket(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_socket(path, error))
    return {"there is no socket at " + path + (error ? " (" + error.message() + ")" : ""),
            "start dccastd, whose log names where it serves, or give that address"};
  if (!values::is_listening(path))
    return {"no program listens at the socket " + path + ", which a dccastd has left",
            "start dccastd again"};
  return {};
}

/// One ssh process replaces the checks that a socket makes otherwise.
Diagnosis through_ssh(const std::string& server, const ProbeOptions& options,
                      std::vector<std::string>& found, std::shared_ptr<Interruption> interruption) {
  SshTunnel tunnel(server);
  std::string answer;
  const Diagnosis way = tunnel.open_and_greet(http2_greeting, options.timeout, answer);
  if (!way.sound()) return way;
  found.push_back("ssh reaches " + tunnel.target() + " on the other machine");
  if (language_of(answer) != Speaks::http2)
    return {"what answers at " + tunnel.target() + " there does not speak gRPC",
            "give the path of dccastd's socket, which its log names: ssh://HOST/PATH"};
  return call({.address = tunnel.address()}, options, found, std::move(interruption));
}

}  // namespace

std::string utc_text(std::int64_t unix_s) {
  return fmt::format("{:%Y-%m-%d %H:%MZ}", fmt::gmtime(unix_s));
}

std::string role_text(v1::Role role) {
  return role == v1::ADMIN ? "admin" : role == v1::SUBMITTER ? "submitter" : "viewer";
}

Diagnosis diagnose(const Endpoint& endpoint, const ProbeOptions& options,
                   std::vector<std::string>& found, std::shared_ptr<Interruption> interruption) {
  const std::string& address = endpoint.address;

  if (SshTunnel::is_meant(address))
    return through_ssh(address, options, found, std::move(interruption));
  if (const auto scheme = address.find("://"); scheme != std::string::npos)
    return {
        "the address begins with " + address.substr(0, scheme + 3) + ", as that of a web page does",
        "write " + address.substr(scheme + 3) + " alone"};

  if (address.starts_with(values::unix_scheme)) {
    const Diagnosis wire =
        at_unix_socket(address.substr(std::string_view(values::unix_scheme).size()));
    if (!wire.sound()) return wire;
    found.push_back("connected to " + address);
    return call(endpoint, options, found, std::move(interruption));
  }

  const values::HostAndPort to = values::host_and_port(address);
  if (to.port.empty())
    return {"the address " + address + " names no port",
            "write " + address + ":7118, or the port of listen.tls that the log of dccastd names"};

  Socket socket(to, options.timeout);
  if (!socket.is_connected()) return without_connection(socket, to, options);
  found.push_back("connected to " + address);
  const Diagnosis wire = secure(socket, to, endpoint, options, found);
  return wire.sound() ? call(endpoint, options, found, std::move(interruption)) : wire;
}

std::string certificate_with_fingerprint(const std::string& address, const std::string& fingerprint,
                                         const ProbeOptions& options) {
  const auto refuse = [](const Diagnosis& why) {
    return CommandFailed(ExitCode::unreachable, why.cause + "; " + why.remedy);
  };

  const values::HostAndPort to = values::host_and_port(address);
  const Socket socket(to, options.timeout);
  if (!socket.is_connected()) throw refuse(without_connection(socket, to, options));
  const Handshake hands(socket, to, "");
  if (!hands.made) throw refuse(no_handshake(to, address, options));

  // Nothing is trusted yet: the fingerprint, which came by another way, decides which certificate
  // of the chain is the CA of the server.
  STACK_OF(X509)* chain = SSL_get_peer_cert_chain(hands.session.get());
  for (int i = 0; i < sk_X509_num(chain); ++i) {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest;
    unsigned size = 0;
    X509_digest(sk_X509_value(chain, i), EVP_sha256(), digest.data(), &size);
    if (values::hexadecimal({digest.data(), size}) != fingerprint) continue;

    const values::Owned<BIO, BIO_free> bio(BIO_new(BIO_s_mem()));
    PEM_write_bio_X509(bio.get(), sk_X509_value(chain, i));
    char* bytes = nullptr;
    const long length = BIO_get_mem_data(bio.get(), &bytes);
    return {bytes, static_cast<std::size_t>(length)};
  }
  throw refuse({"the server at " + address +
                    " does not show the CA with the fingerprint of the line: it is another server, "
                    "or some program in between",
                "do not go on; ask the admin who gave you the line"});
}

}  // namespace dccast::client
