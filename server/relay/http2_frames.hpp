#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

namespace dccast::relay {

/// Head of an HTTP/2 frame (RFC 9113, 4.1 and 6).
struct Frame {
  /// Kinds that are looked at; frames of other kinds are judged by their number alone.
  enum Kind : std::uint8_t {
    data,
    headers,
    rst_stream = 3,
    settings,
    window_update = 8,
    continuation
  };
  /// Flags of a frame.
  static constexpr std::uint8_t end_stream = 1, acknowledgement = 1, end_headers = 4;
  static constexpr std::size_t head_bytes = 9;
  using Head = std::array<unsigned char, head_bytes>;

  /// Reads a head, in network byte order. The reserved bit of the stream is ignored.
  static Frame parse(const Head& head);
  /// The inverse of parse().
  Head head() const;

  std::uint8_t kind = 0, flags = 0;
  /// Number of the call, odd for those of clients; 0 for the connection itself.
  std::uint32_t stream = 0;
  std::size_t size = 0;  ///< of the payload [bytes]
};

/// Splits the bytes of a connection, which arrive cut anywhere, into frame heads and payloads.
class FrameCutter {
public:
  /// @param preface  bytes before the first frame [bytes]
  explicit FrameCutter(std::size_t preface) : payload_left_(preface) {}

  /// Takes the rest of the payload from the front of `bytes`. @return the bytes taken
  std::string_view take_payload(std::string_view& bytes);
  bool at_end_of_payload() const { return payload_left_ == 0; }
  /// Takes a head from the front of `bytes`, after a payload. @return empty if it is not complete
  std::optional<Frame> take_head(std::string_view& bytes);

private:
  /// Bytes of a head of which only a part has arrived.
  Frame::Head head_{};
  std::size_t head_size_ = 0;
  /// Bytes of the present payload that are still to come.
  std::size_t payload_left_;
};

}  // namespace dccast::relay
