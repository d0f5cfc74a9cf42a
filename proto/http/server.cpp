#include "proto/http/server.hpp"

#include <fcntl.h>
#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <condition_variable>
#include <list>
#include <mutex>
#include <optional>
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
      : tls_(tls_context(listening)), acceptor_(listening_acceptor(context_, listening)) {
    service_.limits = limits;
    service_.tls = tls_ ? &*tls_ : nullptr;
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
    thread_ = std::jthread([this] { context_.run(); });
  }

  void stop() {
    service_.stopping = true;
    asio::post(context_, [this] {
      error_code ignored;
      acceptor_.close(ignored);
    });
    if (thread_.joinable()) thread_.join();

    std::unique_lock lock(mutex_);
    for (Slot& slot : slots_) slot.connection->close();
    changed_.wait(lock, [&] { return open_count() == 0; });
    slots_.clear();
  }

private:
  struct Slot {
    std::unique_ptr<Connection> connection;
    bool has_ended = false;
    bool is_being_closed = false;
  };

  void accept() {
    if (!next_) next_ = std::make_unique<Connection>(service_);
    acceptor_.async_accept(next_->context(), [this](const error_code& error, tcp::socket socket) {
      if (service_.stopping) return;
      if (error) {
        // Most likely no descriptors are left; some may be released soon.
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
      } else {
        take(std::move(socket));
      }
      accept();
    });
  }

  /// Serves the peer if there is room for it.
  void take(tcp::socket socket) {
    keep_to_this_process(socket);
    std::unique_lock lock(mutex_);
    slots_.remove_if([](const Slot& slot) { return slot.has_ended; });
    if (!make_room(lock)) return;

    Slot& slot = slots_.emplace_back(Slot{.connection = std::move(next_)});
    slot.connection->begin(std::move(socket), [this, &slot] {
      const std::lock_guard ended(mutex_);
      slot.has_ended = true;
      changed_.notify_all();
    });
  }

  /// Peers that are silent, or ask without end, must not shut others out: the oldest connection
  /// that waits for its peer is closed, else the oldest of all ends with the answer that it is at.
  /// @return whether there is room
  bool make_room(std::unique_lock<std::mutex>& lock) {
    constexpr std::chrono::seconds longest{1};
    const auto has_room = [&] { return open_count() < service_.limits.connections; };
    if (has_room()) return true;

    const auto is_open = [](const Slot& slot) { return !slot.has_ended && !slot.is_being_closed; };
    const auto waiting = std::ranges::find_if(slots_, [&](const Slot& slot) {
      return is_open(slot) && slot.connection->waits_for_peer();
    });
    if (waiting != slots_.end()) {
      waiting->is_being_closed = true;
      waiting->connection->close();
    } else if (const auto asking = std::ranges::find_if(slots_, is_open); asking != slots_.end()) {
      asking->is_being_closed = true;
      asking->connection->leave();
    }
    return changed_.wait_for(lock, longest, has_room);
  }

  std::size_t open_count() const {
    return static_cast<std::size_t>(
        std::ranges::count_if(slots_, [](const Slot& slot) { return !slot.has_ended; }));
  }

  Service service_;
  std::optional<asio::ssl::context> tls_;
  std::unique_ptr<Connection> next_;  // of the peer that is waited for; outlives the sockets below
  asio::io_context context_{1};
  tcp::acceptor acceptor_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::list<Slot> slots_;  // oldest first
  std::jthread thread_;    // last: it uses the others
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
