#pragma once

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "client/session/connection.hpp"
#include "client/web/entrance.hpp"
#include "client/web/request.hpp"
#include "proto/http/server.hpp"

namespace dccast::client {

/// An HTTP or HTTPS server for those whom an Entrance lets in. Replies name what a page may load:
/// files of this server alone.
class WebServer {
public:
  /// Throws CommandFailed: the address is taken or not of this machine, or the certificate cannot
  /// be used for it.
  /// @param is_behind_proxy  all connections are those of one proxy
  explicit WebServer(const http::Server::Listening& listening, bool is_behind_proxy = false);

  /// Where it listens.
  const http::Server& server() const { return *server_; }
  /// A fixed file. @param path  "/app.js"
  void file(const std::string& path, const std::string& type, const std::string& text) {
    files_[path] = {.body = text, .type = type};
  }
  /// What a handler throws becomes a reply with its text and, of a call, its details.
  using Handler = std::function<Reply(const Request&)>;
  /// Registers what answers a path, one part of which may be "*", the name of a request:
  /// "/jobs/*/report". Handlers run in threads of the server, several at a time.
  void get(const std::string& path, Handler handler) {
    answers_["GET " + path] = std::move(handler);
  }
  /// The same of what changes something.
  void post(const std::string& path, Handler handler) {
    answers_["POST " + path] = std::move(handler);
  }
  /// The handler takes the body by Request::next_part.
  void put(const std::string& path, Handler handler) {
    answers_["PUT " + path] = std::move(handler);
  }
  /// Serves those whom the entrance lets in, until the interruption comes.
  void serve(Entrance& entrance, Interruption& interruption);

private:
  Reply reply_to(const http::Request& received, Entrance& entrance) const;
  Reply answer(Request& request) const;

  std::map<std::string, Reply> files_;      // by path
  std::map<std::string, Handler> answers_;  // by method and path
  std::unique_ptr<http::Server> server_;    // last: its threads use the others
};

/// A page that stands by itself, with its style and script inside, such as a report: it is shown
/// without access to anything else.
Reply page_alone(std::string html);

}  // namespace dccast::client
