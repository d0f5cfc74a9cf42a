#include "proto/http/server.hpp"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <filesystem>
#include <list>
#include <mutex>
#include <thread>

#include "tests/support/eventually.hpp"

namespace dccast::http {
namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;
using std::chrono::steady_clock;

/// A peer that sends what it likes.
class Peer {
public:
  explicit Peer(const std::string& path)
      : socket_(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    const sockaddr_un address = address_of(path);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  }
  static sockaddr_un address_of(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    path.copy(address.sun_path, sizeof address.sun_path - 1);
    return address;
  }
  explicit Peer(int port) : socket_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    EXPECT_EQ(::connect(socket_, reinterpret_cast<sockaddr*>(&address), sizeof address), 0);
  }
  ~Peer() { ::close(socket_); }
  Peer(const Peer&) = delete;

  /// @return false: the server has closed the connection
  bool send(const std::string& text) {
    return ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(text.size());
  }

  /// All that comes until the end of the connection, or until `end` has come.
  std::string receive(const std::string& end = {}, milliseconds longest = milliseconds(10000)) {
    const auto deadline = steady_clock::now() + longest;
    std::string text;
    while (end.empty() || text.find(end) == std::string::npos) {
      const auto left = std::chrono::duration_cast<milliseconds>(deadline - steady_clock::now());
      pollfd waiting{.fd = socket_, .events = POLLIN, .revents = 0};
      if (left.count() <= 0 || ::poll(&waiting, 1, static_cast<int>(left.count())) <= 0)
        return text + "(no end in time)";
      char part[4096];
      const ssize_t size = ::recv(socket_, part, sizeof part, 0);
      if (size <= 0) break;
      text.append(part, static_cast<std::size_t>(size));
    }
    return text;
  }

  std::string ask(const std::string& target, const std::string& host = "own") {
    send("GET " + target + " HTTP/1.1\r\nHost: " + host + "\r\nConnection: close\r\n\r\n");
    return receive();
  }

private:
  int socket_;
};

std::string status_of(const std::string& reply) {
  return reply.substr(0, reply.find('\r'));
}

class HttpServer : public testing::Test {
protected:
  static Limits short_limits() {
    return {.body_bytes = 1000, .connections = 4, .time = milliseconds(300)};
  }

  void start(const Limits& limits = short_limits(),
             const Server::Listening& listening = {.host = "127.0.0.1"}) {
    server_ = std::make_unique<Server>(listening, limits);
    server_->start([](const std::string& host) { return host == "own"; },
                   [this](const Request& request) { return handler_(request); });
  }
  int port() const { return server_->port(); }

  Handler handler_ = [](const Request& request) {
    return Reply{.body = request.method + " " + request.path + " " + request.body};
  };
  std::unique_ptr<Server> server_;
};

TEST_F(HttpServer, AnswersRequestsOnOneConnection) {
  start();
  Peer peer(port());
  peer.send("GET /first HTTP/1.1\r\nHost: own\r\n\r\n");
  EXPECT_NE(peer.receive("GET /first ").find("HTTP/1.1 200 OK"), std::string::npos);
  peer.send("POST /second HTTP/1.1\r\nHost: own\r\nContent-Length: 4\r\n\r\nbody");
  peer.receive("POST /second body");
  peer.send("HEAD /third HTTP/1.1\r\nHost: own\r\nConnection: close\r\n\r\n");
  const std::string head = peer.receive();
  EXPECT_NE(head.find("Content-Length: 11"), std::string::npos) << head;
  EXPECT_TRUE(head.ends_with("\r\n\r\n")) << head;
}

TEST_F(HttpServer, RefusesWhatIsNoRequest) {
  start();
  EXPECT_EQ(status_of(Peer(port()).ask("/ HTTP/1.1\r\nnonsense")), "HTTP/1.1 400 Bad Request");
  Peer other(port());
  other.send("PUT / HTTP/1.1\r\nHost: own\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(status_of(other.receive()), "HTTP/1.1 405 Method Not Allowed");
}

TEST_F(HttpServer, AnswersForItsOwnNamesAlone) {
  start();
  EXPECT_EQ(status_of(Peer(port()).ask("/", "own")), "HTTP/1.1 200 OK");
  EXPECT_EQ(status_of(Peer(port()).ask("/", "evil.example")), "HTTP/1.1 403 Forbidden");
  EXPECT_EQ(status_of(Peer(port()).ask("/", "own\r\nHost: own")), "HTTP/1.1 403 Forbidden");
  Peer without(port());
  without.send("GET / HTTP/1.1\r\nConnection: close\r\n\r\n");
  EXPECT_EQ(status_of(without.receive()), "HTTP/1.1 403 Forbidden");
}

TEST_F(HttpServer, HeadersHaveALimitInAllTheirForms) {
  start();
  const std::string much(6000, 'x'), line = "X-Line: " + std::string(100, 'y') + "\r\n";
  EXPECT_EQ(status_of(Peer(port()).ask("/" + much)), "HTTP/1.1 200 OK");

  Peer long_target(port()), long_line(port()), many_lines(port());
  long_target.send("GET /" + much + much);
  EXPECT_EQ(status_of(long_target.receive()), "HTTP/1.1 431 Request Header Fields Too Large");
  long_line.send("GET / HTTP/1.1\r\nHost: own\r\nX-Line: " + much + much);
  EXPECT_EQ(status_of(long_line.receive()), "HTTP/1.1 431 Request Header Fields Too Large");
  many_lines.send("GET / HTTP/1.1\r\nHost: own\r\n");
  for (int i = 0; i < 100; ++i) many_lines.send(line);
  EXPECT_EQ(status_of(many_lines.receive()), "HTTP/1.1 431 Request Header Fields Too Large");
}

TEST_F(HttpServer, BodiesHaveALimitAlsoInChunks) {
  start();
  Peer announced(port()), chunked(port());
  announced.send("POST / HTTP/1.1\r\nHost: own\r\nContent-Length: 1001\r\n\r\n");
  announced.send(std::string(1001, 'x'));
  EXPECT_EQ(status_of(announced.receive()), "HTTP/1.1 413 Payload Too Large");
  chunked.send("POST / HTTP/1.1\r\nHost: own\r\nTransfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 20; ++i) chunked.send("64\r\n" + std::string(100, 'x') + "\r\n");
  EXPECT_EQ(status_of(chunked.receive()), "HTTP/1.1 413 Payload Too Large");
}

/// Receives a body as the handlers of uploads do.
Reply counted(const Request& request) {
  std::size_t bytes = 0, parts = 0;
  for (std::string part; !(part = request.next_part()).empty(); ++parts) bytes += part.size();
  return {.body = std::to_string(bytes) + " bytes"};
}

TEST_F(HttpServer, ABodyThatIsPutComesInParts) {
  handler_ = counted;
  start({.body_bytes = 1000, .upload_bytes = 1 << 20, .time = std::chrono::seconds(5)});
  const std::string head = "PUT /file HTTP/1.1\r\nHost: own\r\n";
  Peer announced(port());
  announced.send(head + "Content-Length: 300000\r\n\r\n");
  for (int i = 0; i < 300; ++i) EXPECT_TRUE(announced.send(std::string(1000, 'x')));
  announced.receive("300000 bytes");
  announced.send(head + "Content-Length: 0\r\nConnection: close\r\n\r\n");  // the next request
  EXPECT_TRUE(announced.receive().ends_with("\r\n\r\n0 bytes"));

  Peer chunked(port());
  chunked.send(head + "Transfer-Encoding: chunked\r\nConnection: close\r\n\r\n");
  for (int i = 0; i < 20; ++i) chunked.send("2710\r\n" + std::string(10000, 'x') + "\r\n");
  chunked.send("0\r\n\r\n");
  EXPECT_TRUE(chunked.receive().ends_with("200000 bytes"));
}

TEST_F(HttpServer, ABodyThatIsPutHasItsOwnLimits) {
  handler_ = counted;
  start({.body_bytes = 1000, .upload_bytes = 100'000, .time = milliseconds(300)});
  const std::string head = "PUT /file HTTP/1.1\r\nHost: own\r\n";
  Peer announced(port()), chunked(port()), slow(port());
  announced.send(head + "Content-Length: 100001\r\n\r\n");
  EXPECT_EQ(status_of(announced.receive()), "HTTP/1.1 413 Payload Too Large");
  chunked.send(head + "Transfer-Encoding: chunked\r\n\r\n");
  for (int i = 0; i < 20; ++i) chunked.send("2710\r\n" + std::string(10000, 'x') + "\r\n");
  EXPECT_NE(chunked.receive().find("more than 100000 bytes"), std::string::npos);
  const auto begin = steady_clock::now();
  slow.send(head + "Content-Length: 50000\r\n\r\n");
  while (slow.send("y") && steady_clock::now() < begin + std::chrono::seconds(10))
    std::this_thread::sleep_for(milliseconds(20));  // the pace of a slow peer
  EXPECT_LT(steady_clock::now(), begin + std::chrono::seconds(3));
  // What is no PUT keeps the limit of bodies.
  Peer post(port());
  post.send("POST / HTTP/1.1\r\nHost: own\r\nContent-Length: 1001\r\n\r\n");
  EXPECT_EQ(status_of(post.receive()), "HTTP/1.1 413 Payload Too Large");
}

TEST_F(HttpServer, ABodyThatNobodyWantsIsNotReadToItsEnd) {
  std::atomic<bool> is_cut = false;
  handler_ = [&](const Request& request) {
    if (request.path == "/refused") return Reply{.body = "not wanted", .status = 403};
    try {
      return counted(request);
    } catch (const CutBody&) {
      is_cut = true;
      throw;
    }
  };
  start({.upload_bytes = 1 << 30, .time = std::chrono::seconds(5)});
  const std::string length = " HTTP/1.1\r\nHost: own\r\nContent-Length: 1000000000\r\n\r\n";
  Peer refused(port());
  refused.send("PUT /refused" + length + std::string(1000, 'x'));
  EXPECT_TRUE(refused.receive().ends_with("not wanted"));

  std::make_unique<Peer>(port())->send("PUT /cut" + length + std::string(1000, 'x'));
  EXPECT_TRUE(eventually([&] { return is_cut.load(); }));
  Peer waiting(port());
  waiting.send("PUT /cut" + length);
  std::this_thread::sleep_for(milliseconds(50));  // the handler waits by then
  server_->stop();                                // ends while a handler waits for the rest
}

TEST_F(HttpServer, ARequestThatComesSlowlyIsGivenUp) {
  start();
  Peer slow(port());
  const auto begin = steady_clock::now();
  slow.send("GET / HTTP/1.1\r\nX: ");
  while (slow.send("y") && steady_clock::now() < begin + std::chrono::seconds(10))
    std::this_thread::sleep_for(milliseconds(20));  // the pace of a slow peer
  EXPECT_LT(steady_clock::now(), begin + std::chrono::seconds(3));
}

TEST_F(HttpServer, SilentPeersMakeRoomForOthers) {
  start({.connections = 4, .time = std::chrono::minutes(5)});
  std::list<Peer> silent;
  for (int i = 0; i < 40; ++i) {
    silent.emplace_back(port());
    EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK") << i;
  }
}

TEST_F(HttpServer, APeerThatIsBeingAnsweredIsNotClosedForANewOne) {
  std::atomic<int> at_work = 0;
  std::atomic<bool> may_end = false;
  handler_ = [&](const Request&) {
    ++at_work;
    may_end.wait(false);
    return Reply{.body = "done"};
  };
  start({.connections = 2, .time = std::chrono::minutes(5)});

  std::list<Peer> peers;
  for (int i = 0; i < 2; ++i)
    peers.emplace_back(port()).send("GET / HTTP/1.1\r\nHost: own\r\nConnection: close\r\n\r\n");
  EXPECT_TRUE(eventually([&] { return at_work == 2; }));
  EXPECT_EQ(Peer(port()).receive(), "");  // there is no room for it
  may_end = true;
  may_end.notify_all();
  for (Peer& peer : peers) EXPECT_TRUE(peer.receive().ends_with("done"));
}

/// A connection on which requests wait is at work for as long as its peer likes.
TEST_F(HttpServer, PeersThatAskWithoutEndMakeRoomForOthers) {
  handler_ = [](const Request&) {
    std::this_thread::sleep_for(milliseconds(20));  // as long as a page of metrics takes
    return Reply{.body = "answer"};
  };
  start({.connections = 2, .time = std::chrono::minutes(5)});

  std::string requests;
  for (int i = 0; i < 500; ++i) requests += "GET / HTTP/1.1\r\nHost: own\r\n\r\n";
  std::list<Peer> greedy;
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(greedy.emplace_back(port()).send(requests));
    EXPECT_NE(greedy.back().receive("answer").find("200 OK"), std::string::npos);
  }
  for (int i = 0; i < 4; ++i) EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK") << i;
}

/// A source that writes parts one after the other, without a thread of its own.
void write_parts(const std::shared_ptr<Stream>& stream, int most, std::atomic<int>& parts) {
  if (most == 0) return stream->end();
  stream->write("part\n", [stream, most, &parts](bool sent) {
    ++parts;
    if (sent) write_parts(stream, most - 1, parts);
  });
}

TEST_F(HttpServer, StreamsEndWithTheirSourceOrTheServer) {
  std::atomic<int> parts = 0, left = 0;
  handler_ = [&](const Request& request) {
    const int most = request.path == "/three" ? 3 : 1 << 30;
    return Reply{.type = "text/event-stream", .stream = [&, most](const auto& stream) {
                   stream->when_left([&] { ++left; });
                   write_parts(stream, most, parts);
                 }};
  };
  start();
  EXPECT_TRUE(Peer(port()).ask("/three").ends_with("\r\n\r\npart\npart\npart\n"));
  EXPECT_EQ(left, 1);

  Peer endless(port());
  endless.send("GET / HTTP/1.1\r\nHost: own\r\n\r\n");
  endless.receive("part\npart\n");
  server_->stop();
  const int parts_then = parts;
  EXPECT_EQ(endless.receive().find("(no end"), std::string::npos);
  EXPECT_EQ(parts, parts_then);
  EXPECT_EQ(left, 2);
}

TEST_F(HttpServer, SilentStreamsHoldNoThreadAndNoticeThatTheirPeerHasLeft) {
  std::mutex mutex;
  std::list<std::shared_ptr<Stream>> streams;
  std::atomic<int> left = 0;
  handler_ = [&](const Request& request) {
    if (request.path == "/") return Reply{.body = "answer"};
    return Reply{.stream = [&](const auto& stream) {
      const std::lock_guard lock(mutex);
      stream->when_left([&] { ++left; });
      streams.push_back(stream);
    }};
  };
  constexpr int peers = 300;
  start({.connections = peers + 1,
         .connections_of_address = peers + 1,
         .handlers = 2,
         .time = milliseconds(300)});

  std::list<Peer> open;
  for (int i = 0; i < peers; ++i)
    open.emplace_back(port()).send("GET /stream HTTP/1.1\r\nHost: own\r\n\r\n");
  const auto count = [&] {
    const std::lock_guard lock(mutex);
    return streams.size();
  };
  EXPECT_TRUE(eventually([&] { return count() == peers; }));
  EXPECT_TRUE(stays([&] { return left == 0; }, milliseconds(600)))
      << "a silent source is no silent peer";
  EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK");

  open.clear();
  EXPECT_TRUE(eventually([&] { return left == peers; }));
  bool sent = true;
  streams.front()->write("too late", [&](bool was_sent) { sent = was_sent; });
  EXPECT_FALSE(sent);
}

TEST_F(HttpServer, AnAddressHasItsShareOfTheConnections) {
  start({.connections = 100, .connections_of_address = 3, .time = std::chrono::minutes(5)});
  std::list<Peer> silent;
  for (int i = 0; i < 10; ++i) {
    silent.emplace_back(port());
    EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK") << i;
  }
  EXPECT_EQ(silent.front().receive(), "");  // it made room
}

/// Others of its address, behind one router, may come without end.
TEST_F(HttpServer, APeerHasTimeToAskWhenItsAddressHasItsShare) {
  start({.connections = 100, .connections_of_address = 3, .time = std::chrono::minutes(5)});
  Peer honest(port());
  std::list<Peer> silent;
  for (int i = 0; i < 20; ++i) silent.emplace_back(port());
  EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK");  // the others are accepted
  EXPECT_EQ(status_of(honest.ask("/")), "HTTP/1.1 200 OK");
}

TEST_F(HttpServer, AllBodiesTogetherHaveALimit) {
  start({.body_bytes = 1000, .all_bodies_bytes = 1500, .time = std::chrono::minutes(5)});
  const std::string begin =
      "POST / HTTP/1.1\r\nHost: own\r\nContent-Length: 1000\r\n"
      "Connection: close\r\n\r\n";
  Peer first(port());
  first.send(begin);
  std::string reply;
  EXPECT_TRUE(eventually([&] {  // the first one may still be on its way
    Peer second(port());
    second.send(begin + std::string(1000, 'x'));
    return (reply = status_of(second.receive())) == "HTTP/1.1 503 Service Unavailable";
  })) << reply;
  first.send(std::string(1000, 'x'));
  EXPECT_NE(first.receive("xxx").find("200 OK"), std::string::npos);
}

TEST_F(HttpServer, StreamsOfAnAddressHaveItsShare) {
  std::mutex mutex;
  std::list<std::shared_ptr<Stream>> streams;
  handler_ = [&](const Request& request) {
    if (request.path != "/stream") return Reply{.body = "answer"};
    return Reply{.stream = [&](const auto& stream) {
      const std::lock_guard lock(mutex);
      streams.push_back(stream);
    }};
  };
  start({.connections = 100, .connections_of_address = 3, .time = std::chrono::minutes(5)});
  const std::string request = "GET /stream HTTP/1.1\r\nHost: own\r\n\r\n";
  std::list<Peer> open;
  for (int i = 0; i < 3; ++i) {
    open.emplace_back(port()).send(request);
    EXPECT_EQ(status_of(open.back().receive("\r\n\r\n")), "HTTP/1.1 200 OK");
  }
  Peer another(port());
  another.send(request);
  const std::string refused = another.receive();
  EXPECT_EQ(status_of(refused), "HTTP/1.1 429 Too Many Requests");
  EXPECT_NE(refused.find("close one of them"), std::string::npos) << refused;
  EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 200 OK");  // what is no stream is answered

  open.pop_front();
  EXPECT_TRUE(eventually([&] {
    open.emplace_back(port()).send(request);
    return status_of(open.back().receive("\r\n\r\n")) == "HTTP/1.1 200 OK";
  }));
  server_->stop();  // the source of the last stream may begin only now
}

/// A folder of its own, which goes with it.
class Folder {
public:
  Folder() : path_(fs::temp_directory_path() / ("dccast-http-" + std::to_string(::getpid()))) {
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  std::string file(const std::string& name) const { return path_ / name; }

private:
  const fs::path path_;
};

TEST_F(HttpServer, ListensAtAUnixSocketOfItsUserAndGroup) {
  const Folder folder;
  const std::string path = folder.file("socket");
  handler_ = [](const Request& request) { return Reply{.body = "from " + request.address}; };
  const auto ask = [&] {
    Peer peer(path);
    peer.send("GET / HTTP/1.1\r\nHost: own\r\nConnection: close\r\n\r\n");
    return peer.receive();
  };
  start(short_limits(), {.socket = path});
  EXPECT_EQ(fs::status(path).permissions(), fs::perms(0660));
  EXPECT_EQ(port(), 0);
  EXPECT_TRUE(ask().ends_with("from 127.0.0.1"));
  EXPECT_THROW(Server({.socket = path}, {}), CannotListen);
  EXPECT_THROW(Server({.socket = std::string(200, 'x')}, {}), CannotListen);
  server_.reset();
  EXPECT_FALSE(fs::exists(path));

  {  // left by a server that was killed
    const int left = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const sockaddr_un address = Peer::address_of(path);
    EXPECT_EQ(::bind(left, reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
    ::close(left);
  }
  start(short_limits(), {.socket = path});
  EXPECT_TRUE(ask().ends_with("from 127.0.0.1"));
}

TEST_F(HttpServer, AFaultOfAHandlerIsAnAnswer) {
  handler_ = [](const Request&) -> Reply { throw std::runtime_error("broken"); };
  start();
  EXPECT_EQ(status_of(Peer(port()).ask("/")), "HTTP/1.1 500 Internal Server Error");
}

TEST_F(HttpServer, TakesAFreePortOfThisMachineOnly) {
  start();
  EXPECT_THROW(Server({.host = "192.0.2.1"}, {}), CannotListen);
  EXPECT_THROW(Server({.host = "127.0.0.1", .port = port()}, {}), CannotListen);
  EXPECT_THROW(Server({.host = "127.0.0.1", .certificate = "/none", .key = "/none"}, {}),
               BadCertificate);
}

}  // namespace
}  // namespace dccast::http
