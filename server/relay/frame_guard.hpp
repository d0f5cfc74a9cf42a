#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/limits.hpp"

namespace dccast::relay {

/// Follows the frames of HTTP/2 (RFC 9113, 4.1) that one client sends, and finds what gRPC 1.51
/// does not bound: calls that are begun and taken back, headers without an end, frames that ask for
/// work and bring none, and requests that are not finished. Adds to each call a header that names
/// its connection. Not safe to use from several threads.
class FrameGuard {
public:
  using Clock = std::chrono::steady_clock;

  /// @param connection  value of the connection header; at most 100 characters
  explicit FrameGuard(std::string_view connection = "");

  /// @param bytes      the next ones of the connection, wherever they are cut
  /// @param forwarded  what goes on to gRPC is added to it
  /// @return           empty, or why the connection is to be ended
  std::string_view take(std::string_view bytes, Clock::time_point now, std::string& forwarded);

  /// What gRPC keeps of calls whose request has not ended [bytes].
  std::size_t unfinished_bytes() const { return unfinished_bytes_; }

private:
  struct Frame {
    std::uint8_t kind = 0, flags = 0;
    std::uint32_t stream = 0;
    std::size_t size = 0;
  };

  std::string_view begin_frame(const Frame& frame, Clock::time_point now);
  void forward_head(const Frame& frame, std::string& forwarded);
  void forward_connection_header(std::string& forwarded);
  std::string_view take_headers(const Frame& frame);
  void take_body(const Frame& frame);
  void keep(std::uint32_t stream, std::size_t bytes);
  void forget(std::uint32_t stream);

  // A client that looks at the first event of a job takes each call back, some hundred a second; an
  // update of a window stands for some 16 kB of an answer, and pings for seconds.
  access::Allowance resets_{1000.0, 2000.0}, begun_{2000.0, 10000.0}, updates_{20000.0, 40000.0},
      others_{200.0, 1000.0};
  int begun_before_acknowledgement_ = 0;
  bool acknowledged_ = false;  ///< our settings, which bound the calls of a connection
  std::size_t preface_left_ = 24;
  std::array<unsigned char, 9> head_{};
  std::size_t head_size_ = 0;
  std::size_t payload_left_ = 0;
  const std::string connection_field_;  ///< the connection header as HPACK writes it
  /// Call whose headers end with the frame at hand, and have yet to get ours.
  std::optional<std::uint32_t> needs_connection_;
  std::size_t header_block_ = 0;
  std::map<std::uint32_t, std::size_t> unfinished_;  ///< bytes by stream that has not ended
  std::size_t unfinished_bytes_ = 0;
};

}  // namespace dccast::relay
