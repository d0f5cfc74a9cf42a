#include "proto/http/server.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <future>
#include <map>
#include <optional>
#include <string_view>
#include <thread>

#include "proto/http/connection.hpp"

namespace dccast::http {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using boost::system::error_code;

/// Child programs must not inherit the descriptor; Asio opens sockets without this flag.
template <class Socket>
void keep_to_this_process(Socket& socket) {
  ::fcntl(socket.native_handle(), F_SETFD, FD_CLOEXEC);
}

std::optional<asio::ssl::context> tls_context(const Server::Listening& listening) {
  if (listening.certificate.empty()) return std::nullopt;
  asio::ssl::context context(asio::ssl::context::tls_server);
  error_code error;

  context.use_certificate_chain_file(listening.certificate, error);
  if (!error) context.use_private_key_file(listening.key, asio::ssl::context::pem, error);
  if (error) throw BadCertificate(error.message());

  ::SSL_CTX_set_min_proto_version(context.native_handle(), TLS1_2_VERSION);
  return context;
}

/// Listens on the first address of the name that is free on this machine.
tcp::acceptor listening_acceptor(asio::io_context& context, const Server::Listening& listening) {
  error_code error;
  const auto found = tcp::resolver(context).resolve(
      listening.host, std::to_string(listening.port),
      tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error) throw CannotListen(error.message());

  for (const auto& entry : found) {
    tcp::acceptor acceptor(context);
    acceptor.open(entry.endpoint().protocol(), error);
    if (error) continue;
    keep_to_this_process(acceptor);
    acceptor.set_option(tcp::acceptor::reuse_address(true));
    acceptor.bind(entry.endpoint(), error);
    if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
    if (!error) return acceptor;
  }
  throw CannotListen(error.message());
}

}  // namespace

class Server::Parts {
public:
  Parts(const Listening& listening, const Limits& limits)
      : service_(limits),
        tls_(tls_context(listening)),
        acceptor_(listening_acceptor(service_.context, listening)) {
    service_.tls = tls_ ? &*tls_ : nullptr;
    service_.when_room = [this] { serve_waiting(); };
  }
  ~Parts() { stop(); }

  int port() const { return acceptor_.local_endpoint().port(); }
  const X509* certificate() const {
    return tls_ ? ::SSL_CTX_get0_certificate(const_cast<asio::ssl::context&>(*tls_).native_handle())
                : nullptr;
  }

  void start(IsOwnHost is_own_host, Handler handler) {
    service_.is_own_host = std::move(is_own_host);
    service_.handler = std::move(handler);
    accept();
    keep_bounds();
    thread_ = std::jthread([this] { service_.context.run(); });
  }

  void stop() {
    if (!thread_.joinable()) return;
    const auto guard = std::make_unique<asio::executor_work_guard<asio::io_context::executor_type>>(
        service_.context.get_executor());
    std::promise<void> closed;
    asio::post(service_.context, [&] {
      error_code ignored;
      stopping_ = true;
      acceptor_.close(ignored);
      waiting_.reset();
      pulse_.cancel();
      for (Connection* connection : service_.open) connection->close();
      closed.set_value();
    });
    closed.get_future().wait();

    // Handlers at work end first: what they answer is no longer sent.
    service_.workers.join();
    guard->reset();
    thread_.join();
  }

private:
  void accept() {
    acceptor_.async_accept([this](const error_code& error, tcp::socket socket) {
      if (stopping_) return;
      if (!error) {
        keep_to_this_process(socket);
        waiting_.emplace(std::move(socket));
        waits_until_ = Connection::Clock::now() + longest_wait_for_room;
        return serve_waiting();
      }
      // Most likely no descriptors are left; some may be released soon.
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
      accept();
    });
  }

  /// Serves the peer that waits, if any, once there is room for it; then the next one.
  void serve_waiting() {
    if (!waiting_ || stopping_) return;
    if (service_.open.size() >= service_.limits.connections) return make_room();

    error_code error;
    const std::string address = waiting_->remote_endpoint(error).address().to_string();
    auto socket = std::move(*waiting_);
    waiting_.reset();
    if (!error) std::make_shared<Connection>(service_, std::move(socket), address)->begin();
    accept();
  }

  /// Peers that are silent, or ask without end, must not shut others out: of the address that has
  /// most connections, the oldest one that waits for its peer is closed, else the oldest one ends
  /// with the answer that it is at.
  void make_room() {
    // One at a time: its end calls for the peer that waits.
    if (std::ranges::any_of(service_.open, &Connection::is_ending)) return;

    const auto taken = connections_by_address();
    const std::string_view greedy =
        std::ranges::max_element(taken, {}, [](const auto& each) { return each.second; })->first;
    const auto of_greedy = [&](const Connection* each) { return each->address() == greedy; };
    const auto silent = std::ranges::find_if(service_.open, [&](const Connection* each) {
      return of_greedy(each) && each->waits_for_peer();
    });
    if (silent != service_.open.end()) return (*silent)->close();
    (*std::ranges::find_if(service_.open, of_greedy))->leave();
  }

  /// What an address has beyond its share ends in the same order. A connection that has just begun
  /// stays: its request is still on the way, and peers of the same address may ask without end.
  void keep_to_shares() {
    auto taken = connections_by_address();
    const auto begun_before = Connection::Clock::now() - time_to_ask;
    const auto is_too_much = [&](const Connection* each) {
      return !each->is_ending() && taken[each->address()] > service_.limits.connections_of_address;
    };

    for (Connection* each : service_.open) {
      if (!each->waits_for_peer() || each->begun() > begun_before || !is_too_much(each)) continue;
      --taken[each->address()];
      each->close();
    }
    for (Connection* each : service_.open) {
      if (each->waits_for_peer() || !is_too_much(each)) continue;
      --taken[each->address()];
      each->leave();
    }
  }

  std::map<std::string_view, std::size_t> connections_by_address() const {
    std::map<std::string_view, std::size_t> taken;
    for (const Connection* each : service_.open)
      if (!each->is_ending()) ++taken[each->address()];
    return taken;
  }

  /// Ends what has waited too long or is too much, several times a second.
  void keep_bounds() {
    constexpr std::chrono::milliseconds interval{100};
    pulse_.expires_after(interval);
    pulse_.async_wait([this](const error_code& error) {
      if (error || stopping_) return;
      const auto now = Connection::Clock::now();
      for (Connection* connection : service_.open)
        if (connection->deadline() < now) connection->close();
      keep_to_shares();

      if (waiting_ && waits_until_ < now) {
        waiting_.reset();
        accept();
      }
      keep_bounds();
    });
  }

  /// For the first request of a peer whose address has its share already.
  static constexpr std::chrono::milliseconds time_to_ask{500};
  /// For a peer that came when all connections were taken.
  static constexpr std::chrono::seconds longest_wait_for_room{1};

  Service service_;
  std::optional<asio::ssl::context> tls_;
  tcp::acceptor acceptor_;
  asio::steady_timer pulse_{service_.context};
  std::optional<tcp::socket> waiting_;  // accepted, without a connection so far
  Connection::Clock::time_point waits_until_;
  bool stopping_ = false;
  std::jthread thread_;  // last: it uses the others
};

Server::Server(const Listening& listening, const Limits& limits)
    : parts_(std::make_unique<Parts>(listening, limits)) {}
Server::~Server() = default;

int Server::port() const {
  return parts_->port();
}

const X509* Server::certificate() const {
  return parts_->certificate();
}

void Server::start(IsOwnHost is_own_host, Handler handler) {
  parts_->start(std::move(is_own_host), std::move(handler));
}

void Server::stop() {
  parts_->stop();
}

}  // namespace dccast::http
