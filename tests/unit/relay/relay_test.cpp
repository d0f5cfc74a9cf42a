#include "server/relay/relay.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <list>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "proto/values/address.hpp"
#include "server/access/certificates.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"

namespace dccast::relay {

namespace {

using namespace std::chrono_literals;
using storage::FileDescriptor;

const std::string greeting =
    "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + std::string("\0\0\0\4\0\0\0\0\0", 9);
const std::string ping = std::string("\0\0\10\6\0\0\0\0\0", 9) + std::string(8, '\0');

/// A client's socket. Whatever it waits for takes at most 10 s.
FileDescriptor connected(const Listener& listener) {
  FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const timeval patience{.tv_sec = 10, .tv_usec = 0};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);

  sockaddr_in address{};
  address.sin_family = AF_INET;
  const auto [host, port] = values::host_and_port(listener.address());
  address.sin_port = htons(static_cast<std::uint16_t>(std::stoi(port)));
  ::inet_pton(AF_INET, host.c_str(), &address.sin_addr);
  EXPECT_EQ(::connect(socket.get(), reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  return socket;
}

/// A client's socket at a path; an invalid one where no one listens.
FileDescriptor connected_at(const std::string& path) {
  sockaddr_un place{};
  place.sun_family = AF_UNIX;
  path.copy(place.sun_path, path.size());
  FileDescriptor client(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const auto* name = reinterpret_cast<const sockaddr*>(&place);
  return ::connect(client.get(), name, sizeof place) == 0 ? std::move(client) : FileDescriptor();
}

void send_all(int socket, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes.remove_prefix(static_cast<std::size_t>(sent));
      continue;
    }
    if (errno != EAGAIN) return;  // the other side has closed it
    pollfd writable{socket, POLLOUT, 0};
    ::poll(&writable, 1, 10000);
  }
}

/// @return so many bytes, or fewer where the other side has ended
std::string receive(int socket, std::size_t size) {
  std::string received;
  std::string buffer(size, '\0');
  while (received.size() < size) {
    pollfd readable{socket, POLLIN, 0};
    if (::poll(&readable, 1, 10000) <= 0) break;
    const ssize_t some = ::recv(socket, buffer.data(), size - received.size(), 0);
    if (some <= 0) break;
    received.append(buffer, 0, static_cast<std::size_t>(some));
  }
  return received;
}

bool has_ended(int socket) {
  pollfd readable{socket, POLLIN, 0};
  char byte = 0;
  return ::poll(&readable, 1, 10000) > 0 && ::recv(socket, &byte, 1, 0) <= 0;
}

const std::string call_without_headers("\0\0\0\1\4\0\0\0\1", 9);

/// The name of the connection behind the headers of a call.
std::string received_name(int service) {
  constexpr std::size_t name_size = 32;
  const std::size_t field_size = 1 + 1 + std::string(connection_header).size() + 1 + name_size;
  const std::string received = receive(service, 9 + 9 + field_size);
  return received.substr(received.size() - std::min(name_size, received.size()));
}

/// @param client  has sent its greeting, and no call
std::string name_of_connection(int client, int service) {
  send_all(client, call_without_headers);
  return received_name(service);
}

/// Sends the pings at once: a test that loses its processor between two of them is no flood.
void flood(int client) {
  std::string pings;
  for (int i = 0; i < 5000; ++i) pings += ping;
  send_all(client, greeting + pings);
}

class RelayTest : public testing::Test {
protected:
  void start(const Bounds& bounds = {.connections = 10},
             std::optional<TlsFiles> tls = std::nullopt) {
    relay_.add(listener_, bounds, std::move(tls));
    relay_.start();
  }

  /// The next socket that gRPC would get; none within 10 s: an invalid one.
  FileDescriptor served() {
    std::unique_lock lock(mutex_);
    if (!changed_.wait_for(lock, 10s, [&] { return !served_.empty(); })) return FileDescriptor();
    FileDescriptor socket = std::move(served_.front());
    served_.pop_front();
    return socket;
  }

  /// Whether the relay has passed a new connection on, instead of ending it. What it passes on
  /// stays.
  bool is_taken(int client) {
    for (const auto end = std::chrono::steady_clock::now() + 10s;
         std::chrono::steady_clock::now() < end;) {
      {
        const std::lock_guard lock(mutex_);
        if (!served_.empty()) {
          taken_.splice(taken_.end(), served_);
          return true;
        }
      }
      pollfd ended{client, POLLIN, 0};
      if (::poll(&ended, 1, 1) > 0) return false;
    }
    ADD_FAILURE() << "the relay neither takes the connection nor ends it";
    return false;
  }

  PeerTable peers_;
  const Listener listener_{"127.0.0.1:0"};
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<FileDescriptor> served_, taken_;
  Relay relay_{
      peers_,
      [this](int socket) {
        const std::lock_guard lock(mutex_);
        served_.emplace_back(socket);
        changed_.notify_all();
      },
      {.all = 1'000'000, .of_user = 1'000'000, .of_strangers = 200'000, .of_machine = 100'000}};
};

TEST_F(RelayTest, BytesPassBothWaysAndThePeerIsKnown) {
  start();
  const FileDescriptor client = connected(listener_);
  const FileDescriptor service = served();
  send_all(client.get(), greeting);
  EXPECT_EQ(receive(service.get(), greeting.size()), greeting);
  send_all(service.get(), "answer");
  EXPECT_EQ(receive(client.get(), 6), "answer");

  const std::string name = name_of_connection(client.get(), service.get());
  EXPECT_EQ(name.find_first_not_of("0123456789abcdef"), std::string::npos);
  const auto peer = peers_.find(name);
  ASSERT_NE(peer, nullptr);
  EXPECT_EQ(peer->address.substr(0, 15), "ipv4:127.0.0.1:");
  EXPECT_FALSE(peer->over_tls);
  EXPECT_EQ(peer->user_id, std::nullopt);  // TCP names no user
  EXPECT_EQ(peers_.find(""), nullptr);
  EXPECT_EQ(peers_.find("1"), nullptr);
}

TEST_F(RelayTest, WhatWasSentBeforeTheEndArrives) {
  start();
  const FileDescriptor client = connected(listener_);
  const std::string answer(3'000'000, 'a');
  std::thread service([&] {
    const FileDescriptor socket = served();
    send_all(socket.get(), answer);
  });
  std::this_thread::sleep_for(100ms);  // the relay's buffers are full by now
  EXPECT_EQ(receive(client.get(), answer.size()), answer);
  EXPECT_TRUE(has_ended(client.get()));
  service.join();
}

TEST_F(RelayTest, TheEndOfAClientIsThatOfItsService) {
  start();
  FileDescriptor client = connected(listener_);
  const FileDescriptor service = served();
  client = FileDescriptor();
  EXPECT_TRUE(has_ended(service.get()));
}

TEST_F(RelayTest, NoMoreIsReadThanIsTaken) {
  start();
  const FileDescriptor client = connected(listener_);
  const FileDescriptor service = served();
  const timeval patience{.tv_sec = 0, .tv_usec = 300'000};
  ::setsockopt(client.get(), SOL_SOCKET, SO_SNDTIMEO, &patience, sizeof patience);

  constexpr int smaller = 65536;  // the system's own buffer, to see ours
  ::setsockopt(client.get(), SOL_SOCKET, SO_SNDBUF, &smaller, sizeof smaller);
  send_all(client.get(), greeting);
  const std::string frame_head("\xff\xff\xff\xf0\0\0\0\0\0", 9);  // a frame of 16 MB, kind unknown
  const std::string content = frame_head + std::string(16'000'000, 'x');
  std::size_t sent = 0;
  for (;;) {
    const ssize_t some =
        ::send(client.get(), content.data() + sent, content.size() - sent, MSG_NOSIGNAL);
    if (some <= 0) break;
    sent += static_cast<std::size_t>(some);
  }
  EXPECT_LT(sent, 12'000'000U);
  EXPECT_EQ(receive(service.get(), greeting.size()), greeting);
}

TEST_F(RelayTest, AHostilePeerIsEnded) {
  start();
  const FileDescriptor client = connected(listener_);
  const FileDescriptor service = served();
  flood(client.get());
  EXPECT_TRUE(has_ended(client.get()));
}

TEST_F(RelayTest, WhoWasHostileWaits) {
  start();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < 10; ++i) {
    const FileDescriptor client = connected(listener_);
    const FileDescriptor service = served();
    flood(client.get());
    EXPECT_TRUE(has_ended(client.get()));
  }
  EXPECT_GT(std::chrono::steady_clock::now() - begin, 150ms);
}

TEST_F(RelayTest, AUserOfThisMachineIsKnown) {
  const TemporaryFolder folder;
  const std::string path = folder / "socket";
  const Listener at_path("unix:" + path);
  relay_.add(at_path, {.connections = 10}, std::nullopt);
  relay_.start();
  const FileDescriptor client = connected_at(path);
  ASSERT_TRUE(client);
  const FileDescriptor service = served();
  send_all(client.get(), greeting);
  receive(service.get(), greeting.size());
  const auto peer = peers_.find(name_of_connection(client.get(), service.get()));
  ASSERT_NE(peer, nullptr);
  EXPECT_EQ(peer->user_id, std::optional(::getuid()));
}

/// A connection of another user of this machine, which the system lets root make.
FileDescriptor connected_as(unsigned user, const std::string& path) {
  FileDescriptor client;
  std::thread([&] {
    ::syscall(SYS_setresuid, user, user, user);  // of this thread alone
    client = connected_at(path);
  }).join();
  return client;
}

TEST_F(RelayTest, OneLocalUserHasItsShareAndRootAlwaysGetsIn) {
  if (::getuid() != 0) GTEST_SKIP() << "only root can connect as several users";
  const TemporaryFolder folder;
  for (auto path = folder.path(); path != std::filesystem::temp_directory_path();
       path = path.parent_path())
    std::filesystem::permissions(path, std::filesystem::perms(0711));
  const std::string path = folder / "socket";
  const Listener at_path("unix:" + path);
  relay_.add(at_path, {.connections = 20, .per_peer = 7}, std::nullopt);
  relay_.start();

  // Two of the 20 are kept for root. Who asks for nothing within a second would make room for
  // others.
  std::string more_than_a_greeting = greeting;
  for (int i = 0; i < 20; ++i) more_than_a_greeting += ping;
  std::vector<FileDescriptor> clients;
  std::map<unsigned, int> taken;
  for (const unsigned user : {65532U, 65533U, 65534U})
    for (int i = 0; i < 10; ++i) {
      clients.push_back(connected_as(user, path));
      ASSERT_TRUE(clients.back());
      send_all(clients.back().get(), more_than_a_greeting);
      if (is_taken(clients.back().get())) ++taken[user];
    }
  EXPECT_EQ(taken, (std::map<unsigned, int>{{65532U, 7}, {65533U, 7}, {65534U, 4}}));

  for (int i = 0; i < 2; ++i) {
    clients.push_back(connected_at(path));
    EXPECT_TRUE(is_taken(clients.back().get()));
  }
}

TEST_F(RelayTest, OneMachineHasItsShare) {
  start({.connections = 10, .per_peer = 2});
  const FileDescriptor first = connected(listener_), second = connected(listener_);
  const FileDescriptor third = connected(listener_);
  EXPECT_TRUE(has_ended(third.get()));
  send_all(first.get(), greeting);
  send_all(second.get(), greeting);
  EXPECT_EQ(receive(served().get(), 1), "P");
}

TEST_F(RelayTest, TheEndClosesAllConnections) {
  start();
  const FileDescriptor client = connected(listener_);
  const FileDescriptor service = served();
  relay_.stop_accepting();
  relay_.close();
  EXPECT_TRUE(has_ended(client.get()));
  EXPECT_TRUE(has_ended(service.get()));
}

TEST(ListenerAtAPath, ReplacesWhatAKilledDaemonLeft) {
  const TemporaryFolder folder;
  const std::string path = folder / "socket";
  {
    const FileDescriptor left(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
    sockaddr_un place{};
    place.sun_family = AF_UNIX;
    path.copy(place.sun_path, path.size());
    ASSERT_EQ(::bind(left.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place), 0);
  }

  {
    const Listener listener("unix:" + path);
    EXPECT_EQ(listener.address(), "unix:" + path);
    EXPECT_THROW(Listener("unix:" + path), std::runtime_error);

    const FileDescriptor client = connected_at(path);
    ASSERT_TRUE(client);
    sockaddr_storage from{};
    socklen_t size = sizeof from;
    const FileDescriptor accepted(
        ::accept(listener.socket(), reinterpret_cast<sockaddr*>(&from), &size));
    EXPECT_EQ(uri_of(host_of(from, size), from), "unix:");
  }
  EXPECT_FALSE(std::filesystem::exists(path));
  EXPECT_THROW(Listener("unix:" + std::string(200, 'x')), std::runtime_error);
  EXPECT_THROW(Listener("unix:"), std::runtime_error);
}

/// A client over TLS that trusts any server.
class TlsClient {
public:
  explicit TlsClient(const Listener& listener) : socket_(connected(listener)) {
    ::signal(SIGPIPE, SIG_IGN);  // OpenSSL writes to sockets that the server has closed
    ::SSL_set_fd(session_.get(), socket_.get());
    constexpr unsigned char http2[]{2, 'h', '2'};
    ::SSL_set_alpn_protos(session_.get(), http2, sizeof http2);
    is_connected_ = ::SSL_connect(session_.get()) == 1;
  }

  bool is_connected() const { return is_connected_; }
  void send(const std::string& bytes) {
    ::SSL_write(session_.get(), bytes.data(), static_cast<int>(bytes.size()));
  }
  /// Sends a KeyUpdate of TLS 1.3, which carries nothing else. @return false: the connection has
  /// ended
  bool renew_keys() {
    return ::SSL_key_update(session_.get(), SSL_KEY_UPDATE_NOT_REQUESTED) == 1 &&
           ::SSL_do_handshake(session_.get()) == 1;
  }
  std::string receive(std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t received = 0;
    while (received < size) {
      const int some =
          ::SSL_read(session_.get(), bytes.data() + received, static_cast<int>(size - received));
      if (some <= 0) break;
      received += static_cast<std::size_t>(some);
    }
    return bytes.substr(0, received);
  }
  /// Serial number of the server's certificate.
  std::string serial() const {
    const std::unique_ptr<X509, decltype(&::X509_free)> certificate(
        ::SSL_get1_peer_certificate(session_.get()), &::X509_free);
    const ASN1_INTEGER* number = ::X509_get0_serialNumber(certificate.get());
    return {reinterpret_cast<const char*>(::ASN1_STRING_get0_data(number)),
            static_cast<std::size_t>(::ASN1_STRING_length(number))};
  }

private:
  FileDescriptor socket_;
  std::unique_ptr<SSL_CTX, decltype(&::SSL_CTX_free)> context_{::SSL_CTX_new(::TLS_client_method()),
                                                               &::SSL_CTX_free};
  std::unique_ptr<SSL, decltype(&::SSL_free)> session_{::SSL_new(context_.get()), &::SSL_free};
  bool is_connected_ = false;
};

class RelayOverTls : public RelayTest {
protected:
  RelayOverTls() {
    pki_.init();
    pki_.issue_server({"127.0.0.1"}, 10);
  }
  TlsFiles files() const { return {pki_.server(), pki_.server_key(), ""}; }

  TemporaryFolder folder_;
  const access::Pki pki_{folder_.path()};
};

TEST_F(RelayOverTls, BytesAreDecryptedAndEncrypted) {
  start({.connections = 10}, files());
  TlsClient client(listener_);
  ASSERT_TRUE(client.is_connected());
  const FileDescriptor service = served();
  client.send(greeting);
  EXPECT_EQ(receive(service.get(), greeting.size()), greeting);

  const std::string answer(1'000'000, 'a');
  std::thread sender([&] { send_all(service.get(), answer); });
  EXPECT_EQ(client.receive(answer.size()), answer);
  sender.join();

  client.send(call_without_headers);
  const auto peer = peers_.find(received_name(service.get()));
  ASSERT_NE(peer, nullptr);
  EXPECT_TRUE(peer->over_tls);
}

TEST_F(RelayOverTls, ARenewedCertificateHoldsForNewConnections) {
  start({.connections = 10}, files());
  TlsClient before(listener_);
  ASSERT_TRUE(before.is_connected());
  const FileDescriptor service = served();
  pki_.issue_server({"127.0.0.1"}, 10);

  const auto renewed = [&] { return TlsClient(listener_).serial() != before.serial(); };
  EXPECT_TRUE(eventually(renewed));

  before.send(greeting);
  EXPECT_EQ(receive(service.get(), greeting.size()), greeting);
}

/// How long a new client waits for its handshake and its service.
std::chrono::duration<double> time_of_a_new_client(const Listener& listener,
                                                   const std::function<FileDescriptor()>& served) {
  const auto begin = std::chrono::steady_clock::now();
  TlsClient client(listener);
  EXPECT_TRUE(client.is_connected());
  EXPECT_TRUE(served());
  return std::chrono::steady_clock::now() - begin;
}

TEST_F(RelayOverTls, APeerThatRenewsItsKeysWithoutEndIsEndedAndDelaysNoOne) {
  start({.connections = 10}, files());
  std::atomic<int> renewals = 0;
  std::atomic<bool> has_ended = false;
  std::jthread hostile([&](const std::stop_token& stop) {
    TlsClient client(listener_);
    while (!stop.stop_requested() && client.renew_keys()) ++renewals;
    has_ended = true;
  });
  ASSERT_TRUE(served());
  ASSERT_TRUE(eventually([&] { return renewals > 100 || has_ended; }));

  EXPECT_LT(time_of_a_new_client(listener_, [&] { return served(); }), 1s);
  EXPECT_TRUE(eventually([&] { return has_ended.load(); }));
}

TEST_F(RelayOverTls, AClientMayRenewItsKeysNowAndThen) {
  start({.connections = 10}, files());
  TlsClient client(listener_);
  const FileDescriptor service = served();
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(client.renew_keys());
  client.send(greeting);
  EXPECT_EQ(receive(service.get(), greeting.size()), greeting);
}

TEST_F(RelayOverTls, HandshakesInSmallPiecesAreEndedAndDelayNoOne) {
  start({.connections = 100}, files());
  // A greeting of 131 kB, of which each record brings one byte.
  constexpr std::size_t size = 131'000;
  std::string message{'\x01', '\x01', '\xff', '\xb4'};
  message.resize(size, 'x');
  std::string pieces;
  for (const char byte : message) pieces += std::string("\x16\x03\x01\0\x01", 5) + byte;

  std::vector<std::jthread> hostile;
  std::atomic<int> ended = 0;
  constexpr int peers = 8;
  for (int i = 0; i < peers; ++i)
    hostile.emplace_back([&] {
      const FileDescriptor client = connected(listener_);
      send_all(client.get(), pieces);
      if (has_ended(client.get())) ++ended;
    });

  EXPECT_LT(time_of_a_new_client(listener_, [&] { return served(); }), 1s);
  hostile.clear();
  EXPECT_EQ(ended, peers);
}

TEST_F(RelayOverTls, FilesThatDoNotFitEachOtherAreRefused) {
  const access::Pki other(folder_.path() / "other");
  other.init();
  other.issue_server({"127.0.0.1"}, 10);
  EXPECT_THROW(relay_.add(listener_, {}, TlsFiles{pki_.server(), other.server_key(), ""}),
               std::runtime_error);
}

TEST_F(RelayOverTls, AKeyThatIsANamedPipeIsRefusedAtOnce) {
  std::filesystem::remove(pki_.server_key());
  ASSERT_EQ(::mkfifo(pki_.server_key().c_str(), 0600), 0);
  EXPECT_THROW(relay_.add(listener_, {}, files()), std::runtime_error);
}

TEST_F(RelayOverTls, OneWhoSpeaksNoTlsGetsNoService) {
  start({.connections = 10}, files());
  const FileDescriptor client = connected(listener_);
  send_all(client.get(), greeting);
  EXPECT_NE(receive(client.get(), 1000).size(), 1000U);
  const std::lock_guard lock(mutex_);
  EXPECT_TRUE(served_.empty());
}

}  // namespace

}  // namespace dccast::relay
