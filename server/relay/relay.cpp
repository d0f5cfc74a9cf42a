#include "server/relay/relay.hpp"

#include <malloc.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <future>
#include <memory>
#include <thread>
#include <utility>
#include <vector>

#include "server/jobs/log.hpp"
#include "server/relay/acceptor.hpp"
#include "server/relay/connection.hpp"
#include "server/relay/reset_toll.hpp"

namespace dccast::relay {

namespace {

namespace asio = boost::asio;
using std::chrono::seconds;

constexpr seconds between_looks_at_certificates{1};
constexpr seconds time_for_last_answers{1};

}  // namespace

class Relay::Loop final : public ConnectionOwner {
public:
  Loop(PeerTable& peers, std::function<void(int)> serve, const MemoryBounds& memory)
      : peers_(peers), serve_(std::move(serve)), memory_(memory) {}

  ~Loop() override { close(); }

  void add(const Listener& listener, const Bounds& bounds, std::optional<TlsFiles> tls) {
    acceptors_.push_back(
        std::make_unique<Acceptor>(context_, *this, listener, bounds,
                                   tls ? std::make_unique<TlsContext>(*std::move(tls)) : nullptr));
  }

  void start() {
    for (const auto& acceptor : acceptors_) acceptor->wait_for_client();
    refresh_certificates();
    thread_ = std::thread([this] { run(); });
  }

  /// Waits for the relay thread: no acceptor accepts once this has returned.
  void stop_accepting() {
    if (!thread_.joinable()) return;
    const auto stopped = std::make_shared<std::promise<void>>();
    asio::post(context_, [this, stopped] {
      for (const auto& acceptor : acceptors_) acceptor->stop_accepting();
      stopped->set_value();
    });
    stopped->get_future().wait();
  }

  void close() {
    if (!thread_.joinable()) return;

    stop_accepting();
    // gRPC has sent its last answers: give clients a second to receive them.
    asio::post(context_, [this] {
      certificates_.cancel();
      trim_.cancel();
      last_answers_.expires_after(time_for_last_answers);
      last_answers_.async_wait([this](const boost::system::error_code& cancelled) {
        if (cancelled) return;
        for (const auto& acceptor : acceptors_) acceptor->end_all();
      });
      closing_ = true;
      stop_when_empty();
    });
    thread_.join();
  }

  // ConnectionOwner.
  PeerTable& peers() override { return peers_; }
  void serve(int socket) override { serve_(socket); }
  const MemoryBounds& memory() const override { return memory_; }

  void on_growth(std::size_t bytes) override {
    constexpr std::size_t between_looks = 1'000'000;
    // Summing up all connections costs time: do it per megabyte, not per frame.
    grown_ += bytes;
    if (grown_ < between_looks) return;

    grown_ = 0;
    bound_memory();
  }

  void on_resets(const Peer& peer, std::size_t resets) override {
    toll_.charge(peer.origin(), resets, ResetToll::Clock::now());
  }
  ResetToll::Clock::time_point reads_at(const Peer& peer) const override {
    return toll_.is_empty() ? ResetToll::Clock::time_point() : toll_.paid_at(peer.origin());
  }

  void on_end(const Connection& connection, bool hostile) override {
    for (const auto& acceptor : acceptors_)
      if (acceptor->remove(connection, hostile)) break;
    if (hostile) trim_later();
    stop_when_empty();
  }

private:
  void run() {
    for (;;) try {
        context_.run();
        return;
      } catch (const std::exception& error) {
        log::error("the relay goes on after: {}", error.what());
      }
  }

  void refresh_certificates() {
    certificates_.expires_after(between_looks_at_certificates);
    certificates_.async_wait([this](const boost::system::error_code& cancelled) {
      if (cancelled) return;
      for (const auto& acceptor : acceptors_) acceptor->refresh_certificates();
      refresh_certificates();
    });
  }

  /// Ends connections until unfinished requests stay within the bounds of memory.
  void bound_memory() {
    for (;;) {
      std::vector<std::shared_ptr<Connection>> connections;
      for (const auto& acceptor : acceptors_)
        connections.insert(connections.end(), acceptor->connections().begin(),
                           acceptor->connections().end());

      std::vector<HeldMemory> held;
      held.reserve(connections.size());
      for (const auto& connection : connections) held.push_back(connection->held());

      const auto beyond = beyond_bounds(held, memory_);
      if (!beyond) return;
      connections[*beyond]->end("unfinished requests hold too much memory");
    }
  }

  /// Returns memory of hostile connections to the system after a quiet time, because the C library
  /// keeps it otherwise.
  void trim_later() {
    constexpr seconds quiet{2};
    trim_.expires_after(quiet);
    trim_.async_wait([](const boost::system::error_code& cancelled) {
      if (!cancelled) ::malloc_trim(0);
    });
  }

  void stop_when_empty() {
    const auto is_empty = [](const auto& acceptor) { return acceptor->connections().empty(); };
    if (closing_ && std::ranges::all_of(acceptors_, is_empty)) context_.stop();
  }

  PeerTable& peers_;
  const std::function<void(int)> serve_;
  const MemoryBounds memory_;
  asio::io_context context_{1};  // hint: one thread
  asio::steady_timer certificates_{context_}, trim_{context_}, last_answers_{context_};
  std::vector<std::unique_ptr<Acceptor>> acceptors_;
  ResetToll toll_;
  std::size_t grown_ = 0;
  bool closing_ = false;
  std::thread thread_;
};

Relay::Relay(PeerTable& peers, std::function<void(int)> serve, const MemoryBounds& memory)
    : loop_(std::make_unique<Loop>(peers, std::move(serve), memory)) {}

Relay::~Relay() = default;

void Relay::add(const Listener& listener, const Bounds& bounds, std::optional<TlsFiles> tls) {
  loop_->add(listener, bounds, std::move(tls));
}

void Relay::start() {
  loop_->start();
}

void Relay::stop_accepting() {
  loop_->stop_accepting();
}

void Relay::close() {
  loop_->close();
}

}  // namespace dccast::relay
