#include "proto/http/connection.hpp"

#include <fmt/format.h>

#include <array>
#include <boost/asio/post.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <cstdint>
#include <optional>
#include <string_view>

#include "proto/http/peer_stream.hpp"
#include "proto/http/target.hpp"

namespace dccast::http {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using beast::error_code;
using WireRequest = beast::http::request<beast::http::string_body>;

/// Buffer for the request that is arriving; its body is moved out of it.
constexpr std::size_t buffer_bytes = 64 * 1024;
/// A peer whose request is refused may still be sending: it reads the reply only if the rest is
/// received for a while.
constexpr std::chrono::milliseconds linger{1000};

Request translated(WireRequest& from) {
  using beast::http::field;
  const auto header = [&](field name) { return std::string(from[name]); };
  Target target = parse_target({from.target().data(), from.target().size()});

  return {.method = from.method() == beast::http::verb::post ? "POST" : "GET",
          .path = std::move(target.path),
          .query = std::move(target.query),
          .host = header(field::host),
          .origin = header(field::origin),
          .cookies = header(field::cookie),
          .body = std::move(from.body())};
}

bool is_known_method(beast::http::verb method) {
  using beast::http::verb;
  return method == verb::get || method == verb::head || method == verb::post;
}

Reply answer(const Service& service, WireRequest& request) {
  if (!is_known_method(request.method()))
    return {.body = "Only GET, HEAD and POST are answered.\n", .status = 405};
  if (request.count(beast::http::field::host) != 1 ||
      !service.is_own_host(std::string(request[beast::http::field::host])))
    return {.body = "The Host of this request is no name of this server.\n", .status = 403};

  try {
    return service.handler(translated(request));
  } catch (const std::exception& error) {
    return {.body = std::string(error.what()) + "\n", .status = 500};
  }
}

/// The reply to a request that cannot be read; empty if the peer has gone or is too slow.
std::optional<Reply> refusal(const error_code& why, const Limits& limits) {
  using beast::http::error;

  if (why == error::header_limit || why == error::buffer_overflow)
    return Reply{
        .body = fmt::format("The header of a request has at most {} bytes.\n", limits.header_bytes),
        .status = 431};
  if (why == error::body_limit)
    return Reply{
        .body = fmt::format("The body of a request has at most {} bytes.\n", limits.body_bytes),
        .status = 413};

  const bool is_malformed = why.category() == make_error_code(error::end_of_stream).category();
  if (!is_malformed || why == error::end_of_stream || why == error::partial_message)
    return std::nullopt;
  return Reply{.body = "This is no request of HTTP/1.1.\n", .status = 400};
}

template <class Body>
beast::http::response<Body> header_of(const Reply& reply, bool keep_alive) {
  using beast::http::field;
  beast::http::response<Body> header;
  header.result(static_cast<unsigned>(reply.status));
  header.set(field::content_type, reply.type);
  for (const auto& [name, value] : reply.headers) header.set(name, value);
  header.keep_alive(keep_alive);
  return header;
}

}  // namespace

class Connection::Session {
public:
  Session(Connection& connection, PeerStream& stream)
      : connection_(connection), service_(connection.service_), stream_(stream) {}

  void serve() {
    beast::flat_buffer buffer(buffer_bytes);
    stream_.expires_after(service_.limits.time);
    if (stream_.handshake()) return;

    while (serve_request(buffer) && !connection_.leaving_) {
    }
    stream_.expires_after(linger);
    stream_.shut_down();
  }

private:
  /// @return whether the connection can take another request
  bool serve_request(beast::flat_buffer& buffer) {
    beast::http::request_parser<beast::http::string_body> parser;
    parser.header_limit(static_cast<std::uint32_t>(service_.limits.header_bytes));
    parser.body_limit(service_.limits.body_bytes);

    stream_.expires_after(service_.limits.time);
    error_code error;
    beast::http::read(stream_, buffer, parser, error);
    if (error) {
      if (const auto reply = refusal(error, service_.limits)) refuse(*reply);
      return false;
    }

    connection_.waits_for_peer_ = false;
    Reply reply = answer(service_, parser.get());
    const bool is_head = parser.get().method() == beast::http::verb::head;
    if (reply.next_part) return send_stream(reply, is_head);

    connection_.waits_for_peer_ = true;
    return send(std::move(reply), parser.keep_alive() && !connection_.leaving_, is_head);
  }

  bool send(Reply reply, bool keep_alive, bool header_only) {
    auto message = header_of<beast::http::string_body>(reply, keep_alive);
    message.body() = std::move(reply.body);
    message.prepare_payload();

    beast::http::response_serializer<beast::http::string_body> serializer(message);
    serializer.split(header_only);
    while (!(header_only ? serializer.is_header_done() : serializer.is_done())) {
      // A long reply may take long, as long as the peer keeps reading.
      stream_.expires_after(service_.limits.time);
      error_code error;
      beast::http::write_some(stream_, serializer, error);
      if (error) return false;
    }
    return keep_alive;
  }

  /// A stream ends with its connection, so that its parts need no frames.
  bool send_stream(const Reply& reply, bool header_only) {
    auto message = header_of<beast::http::empty_body>(reply, false);
    beast::http::response_serializer<beast::http::empty_body> serializer(message);
    stream_.expires_after(service_.limits.time);
    error_code error;
    beast::http::write_header(stream_, serializer, error);
    if (error) return false;

    while (!header_only && !service_.stopping) {
      const std::string part = reply.next_part();
      if (part.empty() || !send_part(part)) break;
    }
    return false;
  }

  bool send_part(std::string_view part) {
    while (!part.empty()) {
      stream_.expires_after(service_.limits.time);
      error_code error;
      part.remove_prefix(stream_.write_some(asio::buffer(part), error));
      if (error) return false;
    }
    return true;
  }

  void refuse(const Reply& reply) {
    send(reply, false, false);
    stream_.expires_after(linger);
    stream_.drain();
  }

  Connection& connection_;
  const Service& service_;
  PeerStream& stream_;
};

void Connection::begin(tcp::socket socket, std::function<void()> ended) {
  thread_ = std::jthread([this, socket = std::move(socket), ended = std::move(ended)]() mutable {
    try {
      PeerStream stream(context_, std::move(socket), service_.tls);
      open_ = &stream;
      Session(*this, stream).serve();
    } catch (const std::exception&) {
      // Memory or a descriptor is missing: this connection ends.
    }
    open_ = nullptr;
    ended();
  });
}

void Connection::close() {
  asio::post(context_, [this] {
    if (open_ != nullptr) open_->close();
  });
}

}  // namespace dccast::http
