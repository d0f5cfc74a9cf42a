#pragma once

#include <functional>
#include <string>
#include <utility>

#include "client/web/web_server.hpp"

namespace dccast::client {

/// Connects to the server of the jobs, for whom a request is.
using Connect = std::function<Connection(const Request&)>;

/// A handler that calls the daemon for whom a request is.
template <class Handler>
WebServer::Handler connected(const Connect& connect, Handler handler) {
  return [=](const Request& request) {
    Connection connection = connect(request);
    connection.set_policy({.attempts = 2});
    return handler(connection, request);
  };
}

/// A stored frame of a job, to be drawn. Throws CommandFailed.
/// @param number  1 is the first one, 0 the last
/// @param field  name of a field, in place of mesh and temperature; empty: these
v1::QueryResultResponse stored_frame(Connection& connection, const std::string& id, int number,
                                     const std::string& field = {});

/// Gives a web server what programs fetch and send by plain HTTP, as docs/programs.md names it:
/// /jobs.csv, /jobs/ID/report, results.h5, curl.csv and frame, and /attachments/SHA256.
void add_resources(WebServer& server, const Connect& connect);

}  // namespace dccast::client
