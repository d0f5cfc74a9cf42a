#include "server/service/frame_guard.hpp"

#include <algorithm>

namespace dccast::service {

namespace {

// RFC 9113, 6.
enum Kind : std::uint8_t {
  data,
  headers,
  rst_stream = 3,
  settings,
  window_update = 8,
  continuation
};
constexpr std::uint8_t end_stream = 1, acknowledgement = 1;

// gRPC takes 8 kB of metadata; what is longer it reads to its end, wherever that is.
constexpr std::size_t most_of_a_header_block = 64 * 1024;
// Of a frame of a body, beside its bytes: a slice, and its place in a list.
constexpr std::size_t kept_per_frame = 64;
constexpr std::size_t kept_per_call = 8 * 1024;
// Those who acknowledge the settings are held to the bound on calls by gRPC.
constexpr int most_begun_before_acknowledgement = 100;

}  // namespace

std::string_view FrameGuard::take(std::string_view bytes, Clock::time_point now) {
  const auto skip = [&](std::size_t& left) {
    const std::size_t some = std::min(left, bytes.size());
    left -= some;
    bytes.remove_prefix(some);
  };
  skip(preface_left_);
  for (;;) {
    skip(payload_left_);
    if (bytes.empty()) return {};
    head_[head_size_++] = static_cast<unsigned char>(bytes.front());
    bytes.remove_prefix(1);
    if (head_size_ < head_.size()) continue;
    head_size_ = 0;
    const Frame frame{.kind = head_[3],
                      .flags = head_[4],
                      .stream = (head_[5] & 0x7fU) << 24 | static_cast<unsigned>(head_[6]) << 16 |
                                static_cast<unsigned>(head_[7]) << 8 | head_[8],
                      .size = static_cast<std::size_t>(head_[0]) << 16 |
                              static_cast<std::size_t>(head_[1]) << 8 | head_[2]};
    payload_left_ = frame.size;
    if (const auto fault = begin_frame(frame, now); !fault.empty()) return fault;
  }
}

std::string_view FrameGuard::begin_frame(const Frame& frame, Clock::time_point now) {
  switch (frame.kind) {
    case headers:
      header_block_ = 0;
      if (!begun_.take(now)) return "it begins calls without end";
      if (!acknowledged_ && ++begun_before_acknowledgement_ > most_begun_before_acknowledgement)
        return "it begins calls and does not acknowledge how many it may";
      if (!(frame.flags & end_stream)) keep(frame.stream, kept_per_call);
      return take_headers(frame);
    case continuation:
      if (!others_.take(now)) return "it sends headers in small pieces";
      return take_headers(frame);
    case data:
      take_body(frame);
      if (frame.size > 0 || frame.flags & end_stream || others_.take(now)) return {};
      return "it sends empty frames";
    case rst_stream:
      forget(frame.stream);
      return resets_.take(now) ? "" : "it takes back its calls";
    case window_update:
      return updates_.take(now) ? "" : "it updates windows without end";
    case settings:
      acknowledged_ = acknowledged_ || frame.flags & acknowledgement;
      [[fallthrough]];
    default:
      return others_.take(now) ? "" : "it sends pings or settings without end";
  }
}

std::string_view FrameGuard::take_headers(const Frame& frame) {
  header_block_ += frame.size;
  return header_block_ > most_of_a_header_block ? "its headers are too long" : "";
}

void FrameGuard::take_body(const Frame& frame) {
  if (frame.flags & end_stream) return forget(frame.stream);
  keep(frame.stream, frame.size + kept_per_frame);
}

void FrameGuard::keep(std::uint32_t stream, std::size_t bytes) {
  unfinished_[stream] += bytes;
  unfinished_bytes_ += bytes;
}

void FrameGuard::forget(std::uint32_t stream) {
  const auto found = unfinished_.find(stream);
  if (found == unfinished_.end()) return;
  unfinished_bytes_ -= found->second;
  unfinished_.erase(found);
}

}  // namespace dccast::service
