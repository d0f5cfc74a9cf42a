#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "client/session/connection.hpp"
#include "proto/http/message.hpp"

namespace dccast::client {

/// What a browser asks for.
struct Request : http::Request {
  std::string name;  ///< last part of the path, decoded

  /// The first value of a query key; empty if there is none.
  std::string value(const std::string& key) const;
  /// All values of a query key, in their order.
  std::vector<std::string> values(const std::string& key) const;
};

/// Answer to a request.
struct Reply {
  std::string body;
  std::string type = "application/json";
  int status = 200;
  /// A page that stands by itself, with its style and script inside, such as a report: it is shown
  /// without access to anything else.
  bool stands_alone = false;
  /// Set: the reply is a stream instead of `body`, see http::Reply.
  std::function<void(std::shared_ptr<http::Stream>)> stream{};
};

/// Where browsers find a server.
struct Listening {
  std::string host = "127.0.0.1";    ///< or a name or address of this machine
  int port = 0;                      ///< 0: any free one
  std::string certificate{}, key{};  ///< PEM files, for HTTPS; empty: HTTP
};

/// An HTTP or HTTPS server for the few who are let in, see Entrance. Replies name what a page may
/// load: files of this server alone.
class WebServer {
public:
  /// Throws CommandFailed: the address is taken or not of this machine, or the certificate cannot
  /// be used for it.
  explicit WebServer(const Listening& listening);
  /// Ends the threads that serve.
  ~WebServer();
  WebServer(const WebServer&) = delete;

  /// A fixed file. @param path  "/app.js"
  void file(const std::string& path, const std::string& type, const std::string& text);
  /// Answers GET (or POST) of `path`/NAME. What the handler throws becomes a reply with its text.
  using Handler = std::function<Reply(const Request&)>;
  /// Registers what answers a path. Handlers run in threads of the server, several at a time.
  void get(const std::string& path, Handler handler);
  void post(const std::string& path, Handler handler);
  /// An address that opens the dashboard once.
  std::string address();
  /// Called each time such an address has let a browser in.
  void when_entered(std::function<void()> call);
  /// Serves until the interruption comes.
  void serve(Interruption& interruption);

private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace dccast::client
