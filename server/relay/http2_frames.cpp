#include "server/relay/http2_frames.hpp"

#include <algorithm>

namespace dccast::relay {

Frame Frame::parse(const Head& head) {
  const auto byte = [&](std::size_t place) { return static_cast<std::uint32_t>(head[place]); };
  return {.kind = head[3],
          .flags = head[4],
          .stream = (byte(5) & 0x7f) << 24 | byte(6) << 16 | byte(7) << 8 | byte(8),
          .size = byte(0) << 16 | byte(1) << 8 | byte(2)};
}

Frame::Head Frame::head() const {
  const auto byte = [](std::size_t value, int place) {
    return static_cast<unsigned char>(value >> (8 * place) & 0xff);
  };
  return {byte(size, 2),   byte(size, 1),   byte(size, 0),   kind,           flags,
          byte(stream, 3), byte(stream, 2), byte(stream, 1), byte(stream, 0)};
}

std::string_view FrameCutter::take_payload(std::string_view& bytes) {
  const std::string_view taken = bytes.substr(0, payload_left_);
  payload_left_ -= taken.size();
  bytes.remove_prefix(taken.size());
  return taken;
}

std::optional<Frame> FrameCutter::take_head(std::string_view& bytes) {
  const std::size_t some = std::min(head_.size() - head_size_, bytes.size());
  std::copy_n(bytes.begin(), some, head_.begin() + static_cast<std::ptrdiff_t>(head_size_));
  head_size_ += some;
  bytes.remove_prefix(some);
  if (head_size_ < head_.size()) return std::nullopt;

  head_size_ = 0;
  const Frame frame = Frame::parse(head_);
  payload_left_ = frame.size;
  return frame;
}

}  // namespace dccast::relay
