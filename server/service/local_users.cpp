#include "server/service/gate.hpp"

#include <arpa/inet.h>
#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <pwd.h>
#include <string.h>
#include <sys/socket.h>

#include <array>
#include <charconv>
#include <optional>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"
#include "proto/values/address.hpp"

namespace dccast::service {

namespace {

struct Endpoint {
  unsigned char family = AF_INET;
  std::array<std::uint32_t, 4> address{};  ///< in network order
  std::uint16_t port = 0;
};

/// @param text  "127.0.0.1:7117" or "[::1]:7117"
std::optional<Endpoint> parse(const std::string& text) {
  const auto [host, port] = values::host_and_port(text);
  Endpoint endpoint;
  if (host.find(':') != std::string::npos) endpoint.family = AF_INET6;
  std::from_chars(port.data(), port.data() + port.size(), endpoint.port);
  if (::inet_pton(endpoint.family, host.c_str(), endpoint.address.data()) != 1) return std::nullopt;
  return endpoint;
}

/// gRPC writes peers as URIs, in which brackets are escaped: "ipv6:%5B::1%5D:40000".
std::optional<Endpoint> parse_peer(const std::string& peer) {
  std::string text = peer.substr(peer.find(':') + 1);
  for (const auto& [escaped, bracket] : {std::pair("%5B", "["), std::pair("%5D", "]")})
    if (const auto at = text.find(escaped); at != std::string::npos) text.replace(at, 3, bracket);
  return parse(text);
}

struct Request {
  nlmsghdr head;
  inet_diag_req_v2 body;
};

/// Asks for the one socket whose own end is `client` and whose other end is `server`.
Request request_for(const Endpoint& client, const Endpoint& server) {
  Request request{};
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;
  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.body.sdiag_family = client.family;
  request.body.sdiag_protocol = IPPROTO_TCP;
  request.body.idiag_states = ~0u;
  auto& id = request.body.id;
  id.idiag_sport = htons(client.port);
  id.idiag_dport = htons(server.port);
  ::memcpy(id.idiag_src, client.address.data(), sizeof id.idiag_src);
  ::memcpy(id.idiag_dst, server.address.data(), sizeof id.idiag_dst);
  id.idiag_cookie[0] = id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  return request;
}

/// @return the user id of the client's socket
std::optional<unsigned> owner(const Endpoint& client, const Endpoint& server) {
  const storage::FileDescriptor socket(
      ::socket(AF_NETLINK, SOCK_DGRAM | SOCK_CLOEXEC, NETLINK_SOCK_DIAG));
  const Request request = request_for(client, server);
  if (!socket || ::send(socket.get(), &request, sizeof request, 0) < 0) return std::nullopt;
  alignas(nlmsghdr) std::array<char, 4096> answer;
  const auto size = ::recv(socket.get(), answer.data(), answer.size(), 0);
  if (size < static_cast<ssize_t>(NLMSG_LENGTH(sizeof(inet_diag_msg)))) return std::nullopt;
  nlmsghdr head;
  inet_diag_msg message;
  ::memcpy(&head, answer.data(), sizeof head);
  ::memcpy(&message, answer.data() + NLMSG_HDRLEN, sizeof message);
  if (head.nlmsg_type != SOCK_DIAG_BY_FAMILY) return std::nullopt;
  return message.idiag_uid;
}

}  // namespace

std::string user_name(unsigned id) {
  passwd entry;
  passwd* found = nullptr;
  std::vector<char> texts(16384);
  const int error = ::getpwuid_r(id, &entry, texts.data(), texts.size(), &found);
  return error == 0 && found != nullptr ? entry.pw_name : std::to_string(id);
}

std::string LocalUsers::name_of(const std::string& peer) {
  const auto client = parse_peer(peer);
  const auto server = parse(address_);
  if (!client || !server) return "";
  const auto id = owner(*client, *server);
  if (!id) return "";
  const std::lock_guard lock(mutex_);
  const auto [at, is_new] = names_.try_emplace(*id);
  if (is_new) at->second = user_name(*id);
  return at->second;
}

}  // namespace dccast::service
