#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/access/limits.hpp"
#include "server/relay/http2_frames.hpp"

namespace dccast::relay {

/// Checks the HTTP/2 frames (RFC 9113, 4.1) of one client for what gRPC 1.51 does not bound: calls
/// that are begun and reset, headers without an end, frames that cause work and carry nothing, and
/// unfinished requests. Adds to each call a header that names its connection. Not safe to use from
/// several threads.
class FrameGuard {
public:
  using Clock = std::chrono::steady_clock;

  /// @param connection  value of the connection header; at most 100 characters
  /// @param most_of_call  content of one call that gRPC holds at most [bytes]
  explicit FrameGuard(std::string_view connection = "", std::size_t most_of_call = SIZE_MAX);

  /// @param bytes      next bytes of the connection, cut anywhere
  /// @param forwarded  receives the bytes for gRPC at its end
  /// @return           reason to end the connection; empty if there is none
  std::string_view take(std::string_view bytes, Clock::time_point now, std::string& forwarded);

  /// Follows gRPC's answers: a call that gRPC has ended holds no memory.
  /// @param bytes  next bytes of the connection, cut anywhere
  void take_answer(std::string_view bytes);

  /// Memory that gRPC holds for unfinished requests [bytes].
  std::size_t unfinished_bytes() const { return unfinished_bytes_; }

  /// Calls that the client has taken back, or made the server take back, since the last question.
  std::size_t take_resets() { return std::exchange(resets_counted_, 0); }

private:
  /// Judges the head of a frame. @return reason to end the connection; empty if there is none
  std::string_view judge(const Frame& frame, Clock::time_point now);
  /// The same for frames with headers: new calls and continuations.
  std::string_view take_headers(const Frame& frame);
  /// The same for a part of a request: what it adds to the memory that gRPC holds.
  std::string_view take_body(const Frame& frame);
  /// Writes a frame's head for gRPC; headers are not marked as complete if one is still to be
  /// added.
  void forward_head(Frame frame, std::string& forwarded);
  /// Adds a continuation with the header that names the connection, and ends the headers with it.
  void forward_connection_header(std::string& forwarded);
  /// Memory that gRPC holds for one unfinished request [bytes].
  struct Unfinished {
    std::size_t content = 0;
    std::size_t around = 0;  ///< for headers and frames
  };
  /// Memory of one request, as far as gRPC reads ahead [bytes].
  std::size_t held(const Unfinished& request) const;
  /// Adds to the memory of a call.
  void keep(std::uint32_t stream, const Unfinished& more);
  /// Takes a call that has ended from the sum.
  void forget(std::uint32_t stream);

  // Rates per second and bursts. A client that reads the first event of each job resets some
  // hundred calls a second; a window update stands for some 16 kB of an answer, a ping for seconds.
  access::Allowance resets_{1000.0, 2000.0}, begun_{2000.0, 10000.0}, updates_{20000.0, 40000.0},
      others_{200.0, 1000.0};
  /// Calls begun before the client acknowledged the bound on them.
  int begun_before_acknowledgement_ = 0;
  bool acknowledged_ = false;  ///< the settings, which bound the calls of a connection
  FrameCutter requests_, answers_;
  const std::string connection_field_;  ///< the connection header as HPACK writes it
  /// Call whose headers end with the current frame and lack the connection header.
  std::optional<std::uint32_t> needs_connection_;
  /// Bytes of the headers that are being sent, over all their frames.
  std::size_t header_block_ = 0;
  std::uint32_t last_begun_ = 0;  ///< largest stream number so far; numbers only grow
  const std::size_t most_of_call_;
  std::map<std::uint32_t, Unfinished> unfinished_;  ///< by open call
  std::size_t unfinished_bytes_ = 0;
  std::size_t resets_counted_ = 0;
};

}  // namespace dccast::relay
