#include "server/relay/connection.hpp"

#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <boost/asio/post.hpp>
#include <stdexcept>
#include <utility>

#include "server/jobs/log.hpp"

namespace dccast::relay {

namespace {

using Outcome = Transfer::Outcome;

constexpr std::chrono::seconds handshake_time{10};
/// A client that accepts nothing for this long has gone. gRPC's ping ends a call within 30 s, but
/// gRPC does not see that its bytes are stuck in the relay.
constexpr std::chrono::seconds stall_time{60};

// A client sends preface, settings and window before its first request, and some pings [bytes].
constexpr std::uint64_t greeting_bytes = 200;

constexpr std::size_t buffer_bytes = 128 * 1024;

/// Buffers of the relay thread. They are shared: what is read is sent on before the next read.
std::array<char, buffer_bytes>& read_buffer() {
  static thread_local std::array<char, buffer_bytes> buffer;
  return buffer;
}
std::string& forward_buffer() {
  static thread_local std::string buffer;
  return buffer;
}

}  // namespace

Connection::Connection(boost::asio::io_context& loop, ConnectionOwner& owner, int socket, Peer peer,
                       SSL_CTX* tls)
    : loop_(loop),
      owner_(owner),
      peer_(std::move(peer)),
      client_{Socket(loop, socket), nullptr},
      deadline_(loop),
      pause_(loop) {
  client_.stream = tls != nullptr ? tls_stream(socket, *tls, turn_) : plain_stream(socket, turn_);
}

Connection::~Connection() {
  if (!name_.empty()) owner_.peers().remove(name_);
}

void Connection::start_at(Clock::time_point when) {
  if (when <= Clock::now()) return start();
  deadline_.expires_at(when);
  deadline_.async_wait([self = shared_from_this()](const boost::system::error_code& cancelled) {
    if (!cancelled && !self->ended_) self->start();
  });
}

void Connection::start() {
  end_after(handshake_time);
  take_turn(&Connection::shake_hands);
}

void Connection::take_turn(Step step) {
  if (ended_) return;
  turn_.begin(Clock::now());
  (this->*step)();
}

bool Connection::is_silent() const {
  return received_ <= greeting_bytes;
}

HeldMemory Connection::held() const {
  if (!guard_) return {.machine = peer_.host};
  return {.user = owner_.peers().user_of(name_),
          .machine = peer_.host,
          .bytes = guard_->unfinished_bytes()};
}

void Connection::shake_hands() {
  const Transfer step = client_.stream->handshake();
  if (step.outcome != Outcome::moved) return wait(client_, step, &Connection::shake_hands);

  // The deadline was that of the handshake.
  deadline_.cancel();
  try {
    open();
  } catch (const std::exception& error) {
    log::warn("a connection of {} is closed: {}", peer_.address, error.what());
    return end();
  }

  carry_requests();
  carry_answers();
}

void Connection::open() {
  client_.stream->describe(peer_);

  std::array<int, 2> pair{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, pair.data()) != 0)
    throw std::runtime_error(std::string("no pair of sockets: ") + ::strerror(errno));

  // With larger buffers on their way, gRPC and the relay work in parallel.
  constexpr int answers_on_their_way = 512 * 1024;
  ::setsockopt(pair[1], SOL_SOCKET, SO_SNDBUF, &answers_on_their_way, sizeof answers_on_their_way);
  service_.emplace(Side{Socket(loop_, pair[0]), plain_stream(pair[0], turn_)});

  name_ = owner_.peers().add(std::make_shared<const Peer>(peer_));
  guard_.emplace(name_, owner_.memory().of_call);
  owner_.serve(pair[1]);
}

void Connection::carry_requests() {
  while (!ended_ && !turn_.is_spent(Clock::now())) {
    if (const auto until = owner_.reads_at(peer_); until > Clock::now())
      return pause(until, &Connection::carry_requests);
    if (!send_rest(*service_, &Connection::carry_requests)) return;
    const Transfer read = client_.stream->read(read_buffer().data(), buffer_bytes);
    if (read.outcome != Outcome::moved) return wait(client_, read, &Connection::carry_requests);
    received_ += read.bytes;

    // A hostile frame is not forwarded.
    std::string& forwarded = forward_buffer();
    forwarded.clear();
    const std::size_t before = guard_->unfinished_bytes();
    const std::string_view fault =
        guard_->take({read_buffer().data(), read.bytes}, FrameGuard::Clock::now(), forwarded);
    report_resets();
    if (!fault.empty()) return end(fault);
    if (guard_->unfinished_bytes() > before) owner_.on_growth(guard_->unfinished_bytes() - before);

    if (!ended_ && !send(*service_, forwarded, &Connection::carry_requests)) return;
  }
  yield(&Connection::carry_requests);
}

void Connection::carry_answers() {
  while (!ended_ && !turn_.is_spent(Clock::now())) {
    if (!send_rest(client_, &Connection::carry_answers)) return;
    const Transfer read = service_->stream->read(read_buffer().data(), buffer_bytes);
    if (read.outcome == Outcome::ended) client_.stream->close();  // all answers are sent
    if (read.outcome != Outcome::moved) return wait(*service_, read, &Connection::carry_answers);

    guard_->take_answer({read_buffer().data(), read.bytes});
    report_resets();
    if (!send(client_, {read_buffer().data(), read.bytes}, &Connection::carry_answers)) return;

    // A short read has emptied the socket: wait instead of trying again.
    if (read.bytes < buffer_bytes)
      return wait(*service_, {Outcome::wait_until_readable}, &Connection::carry_answers);
  }
  yield(&Connection::carry_answers);
}

bool Connection::send(Side& to, std::string_view bytes, Step retry) {
  while (!bytes.empty()) {
    Transfer written{Outcome::turn_is_over};
    if (!turn_.is_spent(Clock::now())) written = to.stream->write(bytes);
    if (written.outcome != Outcome::moved) {
      to.unsent = bytes;
      if (&to == &client_ && written.outcome != Outcome::turn_is_over) end_after(stall_time);
      wait(to, written, retry);
      return false;
    }
    bytes.remove_prefix(written.bytes);
  }
  return true;
}

bool Connection::send_rest(Side& to, Step retry) {
  if (to.unsent.empty()) return true;
  if (&to == &client_) deadline_.cancel();
  const std::string rest = std::exchange(to.unsent, {});
  return send(to, rest, retry);
}

void Connection::wait(Side& side, const Transfer& transfer, Step next) {
  if (transfer.outcome == Outcome::ended) return end(transfer.hostile);
  if (transfer.outcome == Outcome::turn_is_over) return yield(next);
  side.socket.async_wait(
      transfer.outcome == Outcome::wait_until_readable ? Socket::wait_read : Socket::wait_write,
      [self = shared_from_this(), next](const boost::system::error_code&) {
        self->take_turn(next);
      });
}

void Connection::yield(Step next) {
  if (ended_) return;
  boost::asio::post(loop_, [self = shared_from_this(), next] { self->take_turn(next); });
}

void Connection::pause(Clock::time_point until, Step next) {
  pause_.expires_at(until);
  pause_.async_wait([self = shared_from_this(), next](const boost::system::error_code& cancelled) {
    if (!cancelled) self->take_turn(next);
  });
}

void Connection::report_resets() {
  if (const std::size_t resets = guard_->take_resets(); resets > 0) owner_.on_resets(peer_, resets);
}

void Connection::end_after(std::chrono::seconds time) {
  deadline_.expires_after(time);
  deadline_.async_wait([self = shared_from_this()](const boost::system::error_code& cancelled) {
    if (!cancelled) self->end();
  });
}

void Connection::end(std::string_view hostile) {
  if (std::exchange(ended_, true)) return;
  if (!hostile.empty()) log::info("a connection of {} is ended: {}", peer_.address, hostile);
  const auto self = shared_from_this();  // the owner may let go of the last reference

  boost::system::error_code ignored;
  deadline_.cancel(ignored);
  pause_.cancel(ignored);
  client_.socket.close(ignored);
  if (service_) service_->socket.close(ignored);
  client_.stream.reset();
  owner_.on_end(*this, !hostile.empty());
}

}  // namespace dccast::relay
