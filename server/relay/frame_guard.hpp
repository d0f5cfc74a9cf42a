#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/limits.hpp"
#include "server/relay/http2_frames.hpp"

namespace dccast::relay {

/// Follows the frames of HTTP/2 (RFC 9113, 4.1) that one client sends, and finds what gRPC 1.51
/// does not bound: calls that are begun and taken back, headers without an end, frames that ask for
/// work and bring none, and requests that are not finished. Adds to each call a header that names
/// its connection. Not safe to use from several threads.
class FrameGuard {
public:
  using Clock = std::chrono::steady_clock;

  /// @param connection  value of the connection header; at most 100 characters
  /// @param most_of_call  what gRPC holds of the content of one call [bytes]
  explicit FrameGuard(std::string_view connection = "", std::size_t most_of_call = SIZE_MAX);

  /// @param bytes      the next ones of the connection, wherever they are cut
  /// @param forwarded  what goes on to gRPC is added to it
  /// @return           empty, or why the connection is to be ended
  std::string_view take(std::string_view bytes, Clock::time_point now, std::string& forwarded);

  /// Looks at what gRPC answers: a call that it has ended holds nothing any more.
  /// @param bytes  the next ones of the connection, wherever they are cut
  void take_answer(std::string_view bytes);

  /// What gRPC keeps of calls whose request has not ended [bytes].
  std::size_t unfinished_bytes() const { return unfinished_bytes_; }

private:
  std::string_view judge(const Frame& frame, Clock::time_point now);
  std::string_view take_headers(const Frame& frame);
  std::string_view take_body(const Frame& frame);
  void forward_head(Frame frame, std::string& forwarded);
  void forward_connection_header(std::string& forwarded);
  /// What gRPC keeps of a call whose request has not ended [bytes].
  struct Unfinished {
    std::size_t content = 0;
    std::size_t around = 0;  ///< of its headers, and of the frames that its content came in
  };
  std::size_t held(const Unfinished& request) const;
  void keep(std::uint32_t stream, const Unfinished& more);
  void forget(std::uint32_t stream);

  // A client that looks at the first event of a job takes each call back, some hundred a second; an
  // update of a window stands for some 16 kB of an answer, and pings for seconds.
  access::Allowance resets_{1000.0, 2000.0}, begun_{2000.0, 10000.0}, updates_{20000.0, 40000.0},
      others_{200.0, 1000.0};
  int begun_before_acknowledgement_ = 0;
  bool acknowledged_ = false;  ///< our settings, which bound the calls of a connection
  FrameCutter requests_, answers_;
  const std::string connection_field_;  ///< the connection header as HPACK writes it
  /// Call whose headers end with the frame at hand, and have yet to get ours.
  std::optional<std::uint32_t> needs_connection_;
  std::size_t header_block_ = 0;
  std::uint32_t last_begun_ = 0;  ///< numbers of calls only grow
  const std::size_t most_of_call_;
  std::map<std::uint32_t, Unfinished> unfinished_;  ///< by open call
  std::size_t unfinished_bytes_ = 0;
};

}  // namespace dccast::relay
