#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "client/session/connection.hpp"

namespace dccast::client::web {

/// What a browser asks for.
struct Request {
  std::string name;  ///< last part of the path, decoded
  std::multimap<std::string, std::string> query;
  std::string body;

  /// The first value of a query key; empty if there is none.
  std::string value(const std::string& key) const;
  std::vector<std::string> values(const std::string& key) const;
};

struct Reply {
  std::string body;
  std::string type = "application/json";
  int status = 200;
  /// A page that stands by itself, with its style and script inside, such as a report: it is shown
  /// without access to anything else.
  bool stands_alone = false;
};

/// Writes one event to the browser.
using Send = std::function<void(const std::string& json)>;

/// An HTTP server for one person on the loopback address.
///
/// Nobody else gets in: the first visit needs a key that is valid once and gives the session's
/// cookie; Host must be a loopback name with this port, so that no other site can point its own
/// name at it, and whatever changes something must come from a page of this origin. Replies name
/// what a page may load: files of this server alone.
class WebServer {
public:
  /// @param port  0: any free one. Throws CommandFailed: the port is taken.
  explicit WebServer(int port);
  ~WebServer();
  WebServer(const WebServer&) = delete;

  /// A fixed file. @param path  "/app.js"
  void file(const std::string& path, const std::string& type, const std::string& text);
  /// Answers GET (or POST) of `path`/NAME. What the handler throws becomes a reply with its text.
  using Handler = std::function<Reply(const Request&)>;
  void get(const std::string& path, Handler handler);
  void post(const std::string& path, Handler handler);
  /// Answers with server-sent events. The source runs in a thread of its own until it returns; when
  /// the browser has gone, `gone` comes, and the source shall end.
  using Source =
      std::function<void(const Request&, std::shared_ptr<Interruption> gone, const Send& send)>;
  void events(const std::string& path, Source source);

  int port() const;
  /// An address that opens the dashboard once.
  std::string address();
  /// Serves until the interruption comes.
  void serve(const Interruption& interruption);

private:
  class Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace dccast::client::web
