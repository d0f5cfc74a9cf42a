#include "proto/http/server.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <boost/asio/executor_work_guard.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <filesystem>
#include <future>
#include <map>
#include <mutex>
#include <optional>
#include <string_view>
#include <thread>
#include <utility>
#include <variant>

#include "proto/http/connection.hpp"

namespace dccast::http {
namespace {

namespace asio = boost::asio;
namespace fs = std::filesystem;
using asio::ip::tcp;
using local = asio::local::stream_protocol;
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

std::shared_ptr<const X509> certificate_of(asio::ssl::context& context) {
  X509* const certificate = ::SSL_CTX_get0_certificate(context.native_handle());
  ::X509_up_ref(certificate);
  return {certificate, [](const X509* it) { ::X509_free(const_cast<X509*>(it)); }};
}

/// What tells a file from its next version; the second part is its size.
using Version = std::pair<fs::file_time_type, std::uintmax_t>;

Version version_of(const std::string& path) {
  std::error_code ignored;  // of a file that is being replaced
  return {fs::last_write_time(path, ignored), fs::file_size(path, ignored)};
}

using Acceptor = std::variant<tcp::acceptor, local::acceptor>;

/// Opens, binds and begins to listen.
template <class Protocol>
asio::basic_socket_acceptor<Protocol> acceptor_at(asio::io_context& context,
                                                  const typename Protocol::endpoint& endpoint,
                                                  error_code& error) {
  asio::basic_socket_acceptor<Protocol> acceptor(context);
  acceptor.open(endpoint.protocol(), error);
  if (error) return acceptor;
  keep_to_this_process(acceptor);
  acceptor.set_option(asio::socket_base::reuse_address(true), error);
  acceptor.bind(endpoint, error);
  if (!error) acceptor.listen(asio::socket_base::max_listen_connections, error);
  return acceptor;
}

/// Listens at a path. What a server that was killed has left there goes.
local::acceptor local_acceptor(asio::io_context& context, const std::string& path) {
  constexpr mode_t not_of_others = 0117;
  error_code error;
  if (path.size() >= sizeof(sockaddr_un::sun_path)) throw CannotListen("the path is too long");
  local::socket earlier(context);
  earlier.connect(path, error);
  if (error == asio::error::connection_refused) ::unlink(path.c_str());

  const mode_t usual = ::umask(not_of_others);
  auto acceptor = acceptor_at<local>(context, path, error);
  ::umask(usual);
  if (error) throw CannotListen(error.message());
  return acceptor;
}

/// Listens on the first address of the name that is free on this machine.
Acceptor listening_acceptor(asio::io_context& context, const Server::Listening& listening) {
  if (!listening.socket.empty()) return local_acceptor(context, listening.socket);
  error_code error;
  const auto found = tcp::resolver(context).resolve(
      listening.host, std::to_string(listening.port),
      tcp::resolver::passive | tcp::resolver::numeric_service, error);
  if (error) throw CannotListen(error.message());

  for (const auto& entry : found) {
    auto acceptor = acceptor_at<tcp>(context, entry.endpoint(), error);
    if (!error) return acceptor;
  }
  throw CannotListen(error.message());
}

/// Address of a peer, without port. That of a Unix socket is on this machine.
std::string address_of(const tcp::socket& socket, error_code& error) {
  return socket.remote_endpoint(error).address().to_string();
}
std::string address_of(const local::socket&, error_code&) {
  return "127.0.0.1";
}

}  // namespace

class Server::Parts {
public:
  Parts(const Listening& listening, const Limits& limits)
      : listening_(listening),
        service_(limits),
        tls_(tls_context(listening)),
        acceptor_(listening_acceptor(service_.context, listening)) {
    if (tls_) use_tls();
    service_.when_room = [this] { serve_waiting(); };
  }
  ~Parts() {
    stop();
    if (!listening_.socket.empty()) ::unlink(listening_.socket.c_str());
  }

  int port() const {
    const auto* const over_tcp = std::get_if<tcp::acceptor>(&acceptor_);
    return over_tcp == nullptr ? 0 : over_tcp->local_endpoint().port();
  }
  std::shared_ptr<const X509> certificate() const {
    const std::lock_guard lock(certificate_mutex_);
    return certificate_;
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
      std::visit([&](auto& acceptor) { acceptor.close(ignored); }, acceptor_);
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
    std::visit([this](auto& acceptor) { accept(acceptor); }, acceptor_);
  }

  template <class Kind>
  void accept(Kind& acceptor) {
    acceptor.async_accept([this](error_code error, auto socket) {
      if (stopping_) return;
      if (error) {
        // Most likely no descriptors are left; some may be released soon.
        std::this_thread::sleep_for(std::chrono::milliseconds(100));
        return accept();
      }
      keep_to_this_process(socket);
      std::string address = address_of(socket, error);
      if (error) return accept();  // it has left
      waiting_.emplace(std::move(socket), std::move(address));
      waits_until_ = Connection::Clock::now() + longest_wait_for_room;
      serve_waiting();
    });
  }

  /// Serves the peer that waits, if any, once there is room for it; then the next one.
  void serve_waiting() {
    if (!waiting_ || stopping_) return;
    if (service_.open.size() >= service_.limits.connections) return make_room();

    auto [socket, address] = std::move(*waiting_);
    waiting_.reset();
    std::make_shared<Connection>(service_, std::move(socket), std::move(address))->begin();
    accept();
  }

  // ---- Certificate

  /// New connections have what `tls_` holds; those that are open keep what they had.
  void use_tls() {
    service_.tls = &*tls_;
    versions_ = {version_of(listening_.certificate), version_of(listening_.key)};
    const std::lock_guard lock(certificate_mutex_);
    certificate_ = certificate_of(*tls_);
  }

  /// Takes a certificate whose files have changed. Files that do not go together, as while they are
  /// replaced, are read again at the next change.
  void renew_certificate() {
    const std::pair seen{version_of(listening_.certificate), version_of(listening_.key)};
    if (!tls_ || seen == versions_) return;
    try {
      tls_ = tls_context(listening_);
      use_tls();
      listening_.when_renewed("");
    } catch (const BadCertificate& error) {
      versions_ = seen;
      listening_.when_renewed(error.what());
    }
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
      if (each->waits_for_peer() || each->is_stream() || !is_too_much(each)) continue;
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
      if (certificate_is_due_ < now) {
        certificate_is_due_ = now + std::chrono::seconds(1);
        renew_certificate();
      }

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

  const Listening listening_;
  Service service_;
  std::optional<asio::ssl::context> tls_;
  std::pair<Version, Version> versions_;  // of certificate and key, when they were read
  Connection::Clock::time_point certificate_is_due_{};
  mutable std::mutex certificate_mutex_;
  std::shared_ptr<const X509> certificate_;
  Acceptor acceptor_;
  asio::steady_timer pulse_{service_.context};
  /// Accepted, without a connection so far; with its address.
  std::optional<std::pair<PeerStream::Socket, std::string>> waiting_;
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

std::shared_ptr<const X509> Server::certificate() const {
  return parts_->certificate();
}

void Server::start(IsOwnHost is_own_host, Handler handler) {
  parts_->start(std::move(is_own_host), std::move(handler));
}

void Server::stop() {
  parts_->stop();
}

}  // namespace dccast::http
