#include "server/service/connection_watch.hpp"

#include <dlfcn.h>
#include <openssl/ssl.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <mutex>
#include <unordered_map>
#include <utility>

#include "server/jobs/log.hpp"
#include "server/service/frame_guard.hpp"

namespace dccast::service {

ino_t socket_behind(int descriptor) {
  struct stat status;
  return ::fstat(descriptor, &status) == 0 ? status.st_ino : 0;
}

namespace {

struct Connection {
  int descriptor;
  ino_t socket;  ///< behind the descriptor, which is another's once this one is closed
  std::string peer;
  bool over_tls;
  EndedConnections ended_of_listener;
  FrameGuard guard{};  ///< used by the one thread that reads
  std::atomic<std::size_t> unfinished{0};
  std::atomic<bool> ended{false};

  bool is_open() const { return socket_behind(descriptor) == socket; }

  void end(std::string_view why) {
    if (ended.exchange(true)) return;
    ++*ended_of_listener;
    log::info("a connection of {} is ended: {}", peer, why);
    if (is_open()) ::shutdown(descriptor, SHUT_RDWR);  // gRPC sees its end and closes it
  }
};

class Connections {
public:
  std::atomic<std::size_t> most_unfinished{SIZE_MAX};

  void add(std::shared_ptr<Connection> connection) {
    const std::lock_guard lock(mutex_);
    all_[connection->descriptor] = std::move(connection);
  }

  std::shared_ptr<Connection> find(int descriptor) {
    const std::lock_guard lock(mutex_);
    const auto found = all_.find(descriptor);
    return found != all_.end() && found->second->is_open() ? found->second : nullptr;
  }

  /// What a connection holds has changed.
  void grew(std::size_t bytes) {
    if ((grown_ += bytes) < between_looks) return;
    grown_ = 0;
    const std::lock_guard lock(mutex_);
    // One that was ended stays until gRPC has closed it: what had come already is not read.
    std::erase_if(all_, [](const auto& one) { return !one.second->is_open(); });
    const auto held = [](const auto& one) { return one.second->unfinished.load(); };
    for (;;) {
      std::size_t sum = 0;
      for (const auto& one : all_) sum += held(one);
      if (sum <= most_unfinished) return;
      Connection& largest = *std::ranges::max_element(all_, {}, held)->second;
      largest.end("requests that are not finished hold too much memory");
      largest.unfinished = 0;
    }
  }

private:
  static constexpr std::size_t between_looks = 1'000'000;
  std::mutex mutex_;
  std::unordered_map<int, std::shared_ptr<Connection>> all_;  ///< by descriptor
  std::atomic<std::size_t> grown_{0};
};

Connections& connections() {
  static Connections all;
  return all;
}

/// @return whether the connection goes on
bool take(Connection& connection, std::string_view bytes) {
  if (connection.ended) return false;
  const auto fault = connection.guard.take(bytes, FrameGuard::Clock::now());
  if (!fault.empty()) {
    connection.end(fault);
    return false;
  }
  const std::size_t before = connection.unfinished.exchange(connection.guard.unfinished_bytes());
  if (connection.unfinished > before) connections().grew(connection.unfinished - before);
  return !connection.ended;
}

/// Whose bytes this thread has read last: gRPC decrypts them in the same turn.
thread_local std::shared_ptr<Connection> read_last;

bool take_read(int descriptor, const msghdr& message, std::size_t size) {
  read_last = connections().find(descriptor);
  if (!read_last) return true;
  if (read_last->over_tls) return !read_last->ended;
  for (std::size_t i = 0; i < message.msg_iovlen && size > 0; ++i) {
    const iovec& part = message.msg_iov[i];
    const std::size_t some = std::min(size, part.iov_len);
    if (!take(*read_last, {static_cast<const char*>(part.iov_base), some})) return false;
    size -= some;
  }
  return true;
}

using Holder = std::shared_ptr<Connection>;

int place_in_a_session() {
  static const int place = SSL_get_ex_new_index(
      0, nullptr, nullptr, nullptr, [](void*, void* holder, CRYPTO_EX_DATA*, int, long, void*) {
        delete static_cast<Holder*>(holder);
      });
  return place;
}

bool take_decrypted(SSL* session, std::string_view bytes) {
  auto* holder = static_cast<Holder*>(SSL_get_ex_data(session, place_in_a_session()));
  if (holder == nullptr) {
    if (!read_last || !read_last->over_tls) return true;  // none of a listener
    holder = new Holder(read_last);
    SSL_set_ex_data(session, place_in_a_session(), holder);
  }
  return take(**holder, bytes);
}

template <class Function>
Function next_of(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

}  // namespace

void watch_connection(int connection, const std::string& peer, bool over_tls,
                      EndedConnections ended) {
  connections().add(std::shared_ptr<Connection>(
      new Connection{connection, socket_behind(connection), peer, over_tls, std::move(ended)}));
}

std::string peer_read_last() {
  return read_last ? read_last->peer : "";
}

void bound_unfinished_requests(std::size_t most) {
  connections().most_unfinished = most;
}

}  // namespace dccast::service

// Of what is refused, gRPC sees the end of the connection.
extern "C" {

ssize_t recvmsg(int descriptor, msghdr* message, int flags) {
  static const auto next = dccast::service::next_of<decltype(&::recvmsg)>("recvmsg");
  const ssize_t size = next(descriptor, message, flags);
  if (size <= 0 || flags != 0) return size;
  return dccast::service::take_read(descriptor, *message, static_cast<std::size_t>(size)) ? size
                                                                                          : 0;
}

int SSL_read(SSL* session, void* buffer, int room) {
  static const auto next = dccast::service::next_of<decltype(&::SSL_read)>("SSL_read");
  const int size = next(session, buffer, room);
  if (size <= 0) return size;
  const std::string_view bytes(static_cast<const char*>(buffer), static_cast<std::size_t>(size));
  return dccast::service::take_decrypted(session, bytes) ? size : -1;
}
}
