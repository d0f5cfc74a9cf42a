#include "server/relay/socket_owner.hpp"

#include <linux/inet_diag.h>
#include <linux/netlink.h>
#include <linux/sock_diag.h>
#include <netinet/in.h>
#include <string.h>

#include <array>

#include "core/storage/file.hpp"

namespace dccast::relay {

namespace {

struct Request {
  nlmsghdr head;
  inet_diag_req_v2 body;
};

/// Copies port and address in network byte order, as the kernel's request takes them.
void copy_endpoint(const sockaddr_storage& endpoint, __be16& port, __be32 (&address)[4]) {
  if (endpoint.ss_family == AF_INET6) {
    const auto& ipv6 = reinterpret_cast<const sockaddr_in6&>(endpoint);
    port = ipv6.sin6_port;
    ::memcpy(address, &ipv6.sin6_addr, sizeof ipv6.sin6_addr);
  } else {
    const auto& ipv4 = reinterpret_cast<const sockaddr_in&>(endpoint);
    port = ipv4.sin_port;
    ::memcpy(address, &ipv4.sin_addr, sizeof ipv4.sin_addr);
  }
}

/// Netlink request for the one socket whose local end is `client` and whose remote end is `server`.
Request request_for(const sockaddr_storage& client, const sockaddr_storage& server) {
  Request request{};
  request.head.nlmsg_len = sizeof request;
  request.head.nlmsg_type = SOCK_DIAG_BY_FAMILY;

  request.head.nlmsg_flags = NLM_F_REQUEST;
  request.body.sdiag_family = static_cast<__u8>(client.ss_family);
  request.body.sdiag_protocol = IPPROTO_TCP;
  request.body.idiag_states = ~0u;

  auto& id = request.body.id;
  copy_endpoint(client, id.idiag_sport, id.idiag_src);
  copy_endpoint(server, id.idiag_dport, id.idiag_dst);
  id.idiag_cookie[0] = id.idiag_cookie[1] = INET_DIAG_NOCOOKIE;
  return request;
}

/// Owner of a TCP endpoint on this machine; asks the kernel by netlink.
std::optional<unsigned> owner_of_endpoint(const sockaddr_storage& client,
                                          const sockaddr_storage& server) {
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

std::optional<unsigned> owner_of_peer(int socket, const sockaddr_storage& client) {
  if (client.ss_family == AF_UNIX) {
    ucred credentials{};
    socklen_t size = sizeof credentials;
    if (::getsockopt(socket, SOL_SOCKET, SO_PEERCRED, &credentials, &size) != 0)
      return std::nullopt;
    return credentials.uid;
  }

  sockaddr_storage server{};
  socklen_t size = sizeof server;
  if (::getsockname(socket, reinterpret_cast<sockaddr*>(&server), &size) != 0) return std::nullopt;
  return owner_of_endpoint(client, server);
}

}  // namespace dccast::relay
