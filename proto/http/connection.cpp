#include "proto/http/connection.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/post.hpp>
#include <boost/asio/write.hpp>
#include <cstdint>
#include <mutex>

#include "proto/http/target.hpp"

namespace dccast::http {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using beast::error_code;
using Header = beast::http::request_header<>;

/// Most bytes of a request that wait to be read; its body is moved out of them.
constexpr std::size_t buffer_bytes = 64 * 1024;
/// A peer whose request is refused may still be sending: it reads the reply only if the rest is
/// received for a while.
constexpr std::chrono::milliseconds linger{1000};
/// Slowest peer whose long body is waited for.
constexpr std::size_t least_bytes_per_s = 64 * 1024;
/// Least part of the body of a PUT but for the last one, which a peer sends within the usual time.
constexpr std::size_t part_bytes = 64 * 1024;

Request translated(const Header& from, std::string body, const std::string& address) {
  Target target = parse_target({from.target().data(), from.target().size()});
  Request request{.method = std::string(from.method_string()),
                  .path = std::move(target.path),
                  .query = std::move(target.query),
                  .headers = {},
                  .body = std::move(body),
                  .address = address};
  if (from.method() == beast::http::verb::head) request.method = "GET";

  for (const auto& field : from) {
    std::string name(field.name_string());
    for (char& letter : name) letter = beast::detail::ascii_tolower(letter);
    request.headers.emplace(std::move(name), std::string(field.value()));
  }
  return request;
}

/// Why a request is not even looked at; empty: it is.
std::optional<Reply> refusal(const Service& service, const Header& request) {
  using beast::http::field, beast::http::verb;
  const verb method = request.method();
  const bool takes_uploads = service.limits.upload_bytes > 0;
  if (method != verb::get && method != verb::head && method != verb::post &&
      !(method == verb::put && takes_uploads))
    return Reply{.body = takes_uploads ? "Only GET, HEAD, POST and PUT are answered.\n"
                                       : "Only GET, HEAD and POST are answered.\n",
                 .status = 405};
  if (request.count(field::host) != 1 || !service.is_own_host(std::string(request[field::host])))
    return Reply{.body = "The Host of this request is no name of this server.\n", .status = 403};
  return std::nullopt;
}

Reply too_long(std::size_t most_bytes) {
  return {.body = fmt::format("The body of a request has at most {} bytes.\n", most_bytes),
          .status = 413};
}

/// The reply to a request that cannot be read; empty if the peer has gone or is too slow.
/// @param most_body_bytes  of this request
std::optional<Reply> refusal(const error_code& why, const Limits& limits,
                             std::size_t most_body_bytes) {
  using beast::http::error;

  if (why == error::header_limit || why == error::buffer_overflow)
    return Reply{
        .body = fmt::format("The header of a request has at most {} bytes.\n", limits.header_bytes),
        .status = 431};
  if (why == error::body_limit) return too_long(most_body_bytes);

  const bool is_malformed = why.category() == make_error_code(error::end_of_stream).category();
  if (!is_malformed || why == error::end_of_stream || why == error::partial_message)
    return std::nullopt;
  return Reply{.body = "This is no request of HTTP/1.1.\n", .status = 400};
}

}  // namespace

/// The stream of a connection, as its source sees it: any thread may use it, also when the
/// connection has gone.
class ConnectionStream : public Stream, public std::enable_shared_from_this<ConnectionStream> {
public:
  explicit ConnectionStream(std::shared_ptr<Connection> connection)
      : connection_(std::move(connection)) {}

  void write(std::string part, std::function<void(bool)> done) override {
    const bool is_open = pass([&](auto connection) {
      auto send = [connection, part = std::move(part), done]() mutable {
        connection->part_ = std::move(part);
        connection->send_part(std::move(done));
      };
      asio::post(connection->service_.context, std::move(send));
    });
    if (!is_open) done(false);
  }

  void end() override {
    pass([](auto connection) {
      asio::post(connection->service_.context, [connection] { connection->end_stream(); });
    });
  }

  void when_left(std::function<void()> left) override {
    {
      const std::lock_guard lock(mutex_);
      if (connection_) {
        left_ = std::move(left);
        return;
      }
    }
    left();
  }

  /// The connection ends.
  void leave() {
    std::shared_ptr<Connection> connection;
    std::function<void()> left;
    {
      const std::lock_guard lock(mutex_);
      connection.swap(connection_);
      left.swap(left_);
    }
    if (left) left();
  }

private:
  /// The lock holds while something is passed on: a server that stops waits for it.
  template <class Pass>
  bool pass(const Pass& what) {
    const std::lock_guard lock(mutex_);
    if (connection_) what(connection_);
    return connection_ != nullptr;
  }

  std::mutex mutex_;
  std::shared_ptr<Connection> connection_;  // empty: it has ended
  std::function<void()> left_;
};

// ---- Begin and end

Connection::Connection(Service& service, PeerStream::Socket socket, std::string address)
    : service_(service),
      peer_(std::move(socket), service.tls),
      address_(std::move(address)),
      place_(service.open.insert(service.open.end(), this)),
      buffer_(buffer_bytes) {}

Connection::~Connection() {
  release_body();
  service_.open.erase(place_);
  service_.when_room();
}

void Connection::begin() {
  wait_at_most(service_.limits.time);
  if (!peer_.has_tls()) return read_header();
  peer_.async_handshake([self = shared_from_this()](const error_code& error) {
    if (!error && !self->closed_) self->read_header();
  });
}

void Connection::close() {
  if (closed_) return;
  closed_ = true;
  deadline_ = Clock::time_point::max();
  error_code ignored;
  peer_.socket().close(ignored);
  if (stream_) std::exchange(stream_, nullptr)->leave();
}

void Connection::release_body() {
  service_.bodies_bytes -= std::exchange(body_bytes_, 0);
}

// ---- Request

void Connection::read_header() {
  if (closed_) return;
  if (leaving_) return shut_down();
  request_.emplace();
  request_->header_limit(static_cast<std::uint32_t>(service_.limits.header_bytes));
  request_->body_limit(std::max(service_.limits.body_bytes, service_.limits.upload_bytes));

  wait_at_most(service_.limits.time);
  beast::http::async_read_header(peer_, buffer_, *request_,
                                 [self = shared_from_this()](const error_code& error, std::size_t) {
                                   self->go_on(error, &Connection::read_body);
                                 });
}

bool Connection::is_upload() const {
  return service_.limits.upload_bytes > 0 && request_->get().method() == beast::http::verb::put;
}

std::size_t Connection::most_body_bytes() const {
  return is_upload() ? service_.limits.upload_bytes : service_.limits.body_bytes;
}

void Connection::read_body() {
  if (is_upload()) return answer();

  const auto announced = request_->content_length();
  if (announced && *announced > most_body_bytes()) return refuse(too_long(most_body_bytes()));
  request_->body_limit(most_body_bytes());
  const std::size_t bytes = request_->is_done() ? 0
                            : announced         ? *announced
                                                : service_.limits.body_bytes;
  if (bytes > service_.limits.all_bodies_bytes - service_.bodies_bytes)
    return refuse({.body = "Too many requests arrive at once; try again.\n", .status = 503});
  body_bytes_ = bytes;
  service_.bodies_bytes += bytes;

  wait_at_most(service_.limits.time + std::chrono::seconds(bytes / least_bytes_per_s));
  beast::http::async_read(peer_, buffer_, *request_,
                          [self = shared_from_this()](const error_code& error, std::size_t) {
                            self->go_on(error, &Connection::answer);
                          });
}

void Connection::go_on(const boost::system::error_code& error, void (Connection::*next)()) {
  if (closed_) return;
  if (!error) return (this->*next)();

  if (auto reply = refusal(error, service_.limits, most_body_bytes()))
    refuse(std::move(*reply));
  else
    close();
}

void Connection::stop_waiting() {
  deadline_ = Clock::time_point::max();
  waits_for_peer_ = false;
}

void Connection::answer() {
  stop_waiting();

  asio::post(service_.workers, [self = shared_from_this()]() mutable {
    Reply reply = self->handled();
    auto& context = self->service_.context;
    asio::post(context, [self = std::move(self), reply = std::move(reply)]() mutable {
      self->release_body();
      if (self->closed_) return;
      if (!self->request_->is_done()) return self->refuse(std::move(reply));
      if (reply.stream) return self->begin_stream(std::move(reply));
      self->send(std::move(reply), self->request_->keep_alive() && !self->leaving_);
    });
  });
}

/// Called in a thread of the handlers, during which nothing of the request changes but by parts
/// that the handler asks for.
Reply Connection::handled() {
  const Header& header = request_->get();
  if (auto refused = refusal(service_, header)) return std::move(*refused);

  try {
    Request request = translated(header, std::move(request_->get().body()), address_);
    if (is_upload()) request.next_part = [this] { return next_part(); };
    return service_.handler(request);
  } catch (const CutBody& error) {
    return {.body = std::string(error.what()) + "\n", .status = 400};
  } catch (const std::exception& error) {
    return {.body = std::string(error.what()) + "\n", .status = 500};
  }
}

std::string Connection::next_part() {
  const auto part = std::make_shared<std::promise<std::string>>();
  asio::post(service_.context, [self = shared_from_this(), part] {
    self->wait_at_most(self->service_.limits.time);
    self->waits_for_peer_ = true;
    self->receive_part(part);
  });
  return part->get_future().get();
}

void Connection::receive_part(const Part& part) {
  std::string& body = request_->get().body();
  if (request_->is_done() || body.size() >= part_bytes) {
    stop_waiting();
    return part->set_value(std::exchange(body, {}));
  }

  beast::http::async_read_some(
      peer_, buffer_, *request_,
      [self = shared_from_this(), part](const error_code& error, std::size_t) {
        if (!error && !self->closed_) return self->receive_part(part);
        self->stop_waiting();
        const std::string why =
            error == beast::http::error::body_limit
                ? fmt::format("The body has more than {} bytes.", self->most_body_bytes())
                : "The rest of the body did not come in time; send it again.";
        part->set_exception(std::make_exception_ptr(CutBody(why)));
      });
}

// ---- Reply

void Connection::send(Reply reply, bool keep_alive) {
  using beast::http::field;
  waits_for_peer_ = true;
  response_ = {};
  response_.result(static_cast<unsigned>(reply.status));
  response_.set(field::content_type, reply.type);
  for (const auto& [name, value] : reply.headers) response_.set(name, value);
  response_.keep_alive(keep_alive);
  response_.body() = std::move(reply.body);
  if (!reply.stream && !response_.has_content_length()) response_.prepare_payload();

  rest_.emplace(response_);
  rest_->split(reply.stream || request_->get().method() == beast::http::verb::head);
  send_rest();
}

/// A long reply may take long, as long as the peer keeps reading.
void Connection::send_rest() {
  wait_at_most(service_.limits.time);
  beast::http::async_write_some(
      peer_, *rest_, [self = shared_from_this()](const error_code& error, std::size_t) {
        if (self->closed_) return;
        if (error) return self->close();
        const bool is_sent =
            self->rest_->split() ? self->rest_->is_header_done() : self->rest_->is_done();
        if (!is_sent) return self->send_rest();

        if (self->stream_) return self->notice_end_of_peer();
        if (self->response_.keep_alive()) return self->read_header();
        self->request_ ? self->shut_down() : self->drain();
      });
}

void Connection::refuse(Reply reply) {
  // A request that was not read to its end: what follows it is not looked at.
  send(std::move(reply), false);
  request_.reset();
}

/// Ends the sending, and receives what the peer still sends. Below TLS: it is not looked at.
void Connection::drain() {
  error_code ignored;
  peer_.socket().shutdown(asio::socket_base::shutdown_send, ignored);
  wait_at_most(linger);

  const auto received = [this](const auto& again) -> void {
    buffer_.clear();
    peer_.socket().async_read_some(
        buffer_.prepare(buffer_bytes / 4),
        [self = shared_from_this(), again](const error_code& error, std::size_t) {
          if (self->closed_) return;
          error ? self->close() : again(again);
        });
  };
  received(received);
}

void Connection::shut_down() {
  if (!peer_.has_tls()) return close();
  wait_at_most(linger);
  peer_.async_shutdown([self = shared_from_this()](const error_code&) { self->close(); });
}

// ---- Stream

/// A stream ends with its connection, so that its parts need no frames.
void Connection::begin_stream(Reply reply) {
  if (request_->get().method() == beast::http::verb::head) {
    reply.stream = nullptr;
    return send(std::move(reply), false);
  }
  if (!has_room_for_stream())
    return refuse({.body = fmt::format("{} streams of your address are open here, which is the "
                                       "limit; close one of them, then try again.\n",
                                       service_.limits.connections_of_address),
                   .status = 429});

  stream_ = std::make_shared<ConnectionStream>(shared_from_this());
  auto source = reply.stream;
  send(std::move(reply), false);
  waits_for_peer_ = false;
  asio::post(service_.workers, [source = std::move(source), stream = stream_] { source(stream); });
}

bool Connection::has_room_for_stream() const {
  const auto taken = std::ranges::count_if(service_.open, [&](const Connection* each) {
    return each->is_stream() && each->address() == address_;
  });
  return static_cast<std::size_t>(taken) < service_.limits.connections_of_address;
}

/// The header is sent: the parts follow, meanwhile nothing comes from the peer but its end.
void Connection::notice_end_of_peer() {
  deadline_ = Clock::time_point::max();
  buffer_.clear();
  peer_.async_read_some(buffer_.prepare(1), [self = shared_from_this()](
                                                const error_code&, std::size_t) { self->close(); });
}

void Connection::send_part(std::function<void(bool)> done) {
  if (closed_) return done(false);
  wait_at_most(service_.limits.time);
  asio::async_write(
      peer_, asio::buffer(part_),
      [self = shared_from_this(), done = std::move(done)](const error_code& error, std::size_t) {
        if (error) self->close();
        self->deadline_ = Clock::time_point::max();
        done(!error);
      });
}

void Connection::end_stream() {
  if (closed_) return;
  std::exchange(stream_, nullptr)->leave();
  shut_down();
}

}  // namespace dccast::http
