#include "server/access/machine_names.hpp"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <fstream>

#include "core/storage/file.hpp"

namespace dccast::access {

namespace {

// getifaddrs() would open a netlink socket, which the sandbox of the service forbids.

std::vector<std::string> ipv4_addresses() {
  constexpr std::size_t most = 256;
  std::array<ifreq, most> interfaces{};
  ifconf request{};
  request.ifc_len = static_cast<int>(sizeof interfaces);
  request.ifc_req = interfaces.data();
  const storage::FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket || ::ioctl(socket.get(), SIOCGIFCONF, &request) != 0) return {};

  std::vector<std::string> addresses;
  for (std::size_t i = 0; i < static_cast<std::size_t>(request.ifc_len) / sizeof(ifreq); ++i) {
    std::array<char, INET_ADDRSTRLEN> text{};
    const auto* address = reinterpret_cast<const sockaddr_in*>(&interfaces[i].ifr_addr);
    ::inet_ntop(AF_INET, &address->sin_addr, text.data(), text.size());
    addresses.emplace_back(text.data());
  }
  return addresses;
}

std::vector<std::string> ipv6_addresses() {
  // A line begins with the address, 32 hexadecimal digits.
  std::ifstream interfaces("/proc/self/net/if_inet6");
  std::vector<std::string> addresses;
  for (std::string line; std::getline(interfaces, line);) {
    in6_addr address{};
    constexpr std::size_t digits = 2 * sizeof address;
    if (line.size() < digits) continue;
    for (std::size_t i = 0; i < sizeof address; ++i)
      address.s6_addr[i] =
          static_cast<std::uint8_t>(std::stoul(line.substr(2 * i, 2), nullptr, 16));
    std::array<char, INET6_ADDRSTRLEN> text{};
    ::inet_ntop(AF_INET6, &address, text.data(), text.size());
    addresses.emplace_back(text.data());
  }
  return addresses;
}

}  // namespace

std::vector<std::string> host_names() {
  std::array<char, 256> host{};
  ::gethostname(host.data(), host.size() - 1);
  std::vector<std::string> names{host.data(), "localhost"};

  for (const auto& addresses : {ipv4_addresses(), ipv6_addresses()})
    for (const std::string& address : addresses)
      if (std::find(names.begin(), names.end(), address) == names.end()) names.push_back(address);
  return names;
}

}  // namespace dccast::access
