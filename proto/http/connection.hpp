#pragma once

// Only for the sources of this room: Asio and Beast take seconds to compile.
#include <boost/asio/io_context.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/thread_pool.hpp>
#include <boost/beast/core/buffers_range.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <chrono>
#include <cstdint>
#include <functional>
#include <future>
#include <list>
#include <memory>
#include <optional>
#include <string>

#include "proto/http/peer_stream.hpp"
#include "proto/http/server.hpp"

namespace dccast::http {

class Connection;
class ConnectionStream;

/// What all connections of a server share. All of it but the limits belongs to the thread that
/// runs `context`.
struct Service {
  explicit Service(const Limits& within) : limits(within), workers(within.handlers) {}

  const Limits limits;
  IsOwnHost is_own_host;
  Handler handler;
  boost::asio::ssl::context* tls = nullptr;  ///< null: HTTP
  std::list<Connection*> open{};             ///< oldest first
  std::size_t bodies_bytes = 0;              ///< of requests that are read or answered
  std::function<void()> when_room = [] {};   ///< called after a connection has ended

  boost::asio::io_context context{1};
  boost::asio::thread_pool workers;  ///< the threads of the handlers
};

/// One connection. Its methods are called by the thread that runs the context of the service, which
/// never waits for a peer; it lives as long as something of it is under way.
class Connection : public std::enable_shared_from_this<Connection> {
public:
  using Clock = std::chrono::steady_clock;

  /// @param service  outlives the connection
  Connection(Service& service, PeerStream::Socket socket, std::string address);
  ~Connection();
  Connection(const Connection&) = delete;

  /// Begins to serve the peer until it leaves or exceeds a bound.
  void begin();
  /// Ends everything at once.
  void close();
  /// Ends the connection once the request at work is answered.
  void leave() { leaving_ = true; }

  /// Until when the peer must have done what is waited for.
  Clock::time_point deadline() const { return deadline_; }
  const std::string& address() const { return address_; }  ///< of the peer, without port
  Clock::time_point begun() const { return begun_; }
  bool is_ending() const { return leaving_ || closed_; }
  /// Nothing is being computed for the peer: it has not sent its request, or not taken its reply.
  bool waits_for_peer() const { return waits_for_peer_; }
  bool is_stream() const { return stream_ != nullptr; }  ///< its reply goes on

private:
  friend class ConnectionStream;
  using Response = boost::beast::http::response<boost::beast::http::string_body>;

  /// A body as it is received. Beast's own reserves at once what a peer merely announces.
  struct Body {
    using value_type = std::string;
    /// What Beast hands the bytes of a body to; the names are its own.
    class reader {
    public:
      /// @param body  receives the bytes
      template <bool is_request, class Fields>
      reader(boost::beast::http::header<is_request, Fields>&, std::string& body) : body_(body) {}
      /// The body begins, with this length if it is known.
      void init(const boost::optional<std::uint64_t>&, boost::beast::error_code& error) {
        error = {};
      }
      /// Takes the next bytes. @return their number
      template <class Buffers>
      std::size_t put(const Buffers& buffers, boost::beast::error_code& error) {
        error = {};
        const std::size_t before = body_.size();
        for (const auto part : boost::beast::buffers_range_ref(buffers))
          body_.append(static_cast<const char*>(part.data()), part.size());
        return body_.size() - before;
      }
      /// The body is whole.
      void finish(boost::beast::error_code& error) { error = {}; }

    private:
      std::string& body_;
    };
  };

  void read_header();
  bool is_upload() const;
  std::size_t most_body_bytes() const;
  void read_body();
  /// What was read of the request is followed by the next step, or refused, or the peer has gone.
  void go_on(const boost::system::error_code& error, void (Connection::*next)());
  void stop_waiting();
  void answer();
  Reply handled();
  using Part = std::shared_ptr<std::promise<std::string>>;
  std::string next_part();
  void receive_part(const Part& part);
  void send(Reply reply, bool keep_alive);
  void send_rest();
  void refuse(Reply reply);
  void drain();
  void shut_down();

  void begin_stream(Reply reply);
  bool has_room_for_stream() const;
  void notice_end_of_peer();
  void send_part(std::function<void(bool)> done);
  void end_stream();

  void wait_at_most(Clock::duration time) { deadline_ = Clock::now() + time; }
  void release_body();

  Service& service_;
  PeerStream peer_;
  const std::string address_;
  const Clock::time_point begun_ = Clock::now();
  std::list<Connection*>::iterator place_;  // in the list of the service
  Clock::time_point deadline_ = Clock::time_point::max();
  bool waits_for_peer_ = true, leaving_ = false, closed_ = false;

  boost::beast::flat_buffer buffer_;
  std::optional<boost::beast::http::request_parser<Body>> request_;
  std::size_t body_bytes_ = 0;  // of the request, as counted by the service
  Response response_;
  std::optional<boost::beast::http::response_serializer<boost::beast::http::string_body>> rest_;
  std::shared_ptr<ConnectionStream> stream_;
  std::string part_;  // of the stream, which is being sent
};

}  // namespace dccast::http
