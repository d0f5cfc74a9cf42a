#include "server/relay/frame_guard.hpp"

#include <algorithm>
#include <utility>

#include "server/relay/peer_table.hpp"

namespace dccast::relay {

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
constexpr std::uint8_t end_stream = 1, acknowledgement = 1, end_headers = 4;

// gRPC takes 8 kB of metadata; what is longer it reads to its end, wherever that is.
constexpr std::size_t most_of_a_header_block = 64 * 1024;
// Of a frame of a body, beside its bytes: a slice, and its place in a list.
constexpr std::size_t kept_per_frame = 64;
constexpr std::size_t kept_per_call = 8 * 1024;
// Those who acknowledge the settings are held to the bound on calls by gRPC.
constexpr int most_begun_before_acknowledgement = 100;

/// A header as HPACK writes one that enters no table (RFC 7541, 6.2.2), without Huffman's code. It
/// needs no knowledge of the table, and leaves it as it is.
std::string literal_field(std::string_view name, std::string_view value) {
  std::string field(1, '\0');
  for (const std::string_view text : {name, value}) {
    field += static_cast<char>(text.size());  // below 127: one byte
    field += text;
  }
  return field;
}

}  // namespace

FrameGuard::FrameGuard(std::string_view connection)
    : connection_field_(literal_field(connection_header, connection)) {}

std::string_view FrameGuard::take(std::string_view bytes, Clock::time_point now,
                                  std::string& forwarded) {
  const auto pass = [&](std::size_t& left) {
    const std::size_t some = std::min(left, bytes.size());
    forwarded += bytes.substr(0, some);
    left -= some;
    bytes.remove_prefix(some);
  };

  pass(preface_left_);
  for (;;) {
    pass(payload_left_);
    if (payload_left_ == 0 && needs_connection_) forward_connection_header(forwarded);
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
    forward_head(frame, forwarded);
  }
}

void FrameGuard::forward_head(const Frame& frame, std::string& forwarded) {
  // The headers of a call do not end where the client ends them: a frame of ours follows.
  if ((frame.kind == headers || frame.kind == continuation) && frame.flags & end_headers) {
    head_[4] = static_cast<unsigned char>(frame.flags & ~end_headers);
    needs_connection_ = frame.stream;
  }
  forwarded.append(head_.begin(), head_.end());
}

void FrameGuard::forward_connection_header(std::string& forwarded) {
  const std::uint32_t stream = *std::exchange(needs_connection_, std::nullopt);
  const auto byte = [](std::size_t value, int place) {
    return static_cast<char>(value >> (8 * place) & 0xff);
  };

  forwarded += {byte(connection_field_.size(), 2), byte(connection_field_.size(), 1),
                byte(connection_field_.size(), 0), continuation, end_headers};
  for (int place = 3; place >= 0; --place) forwarded += byte(stream, place);
  forwarded += connection_field_;
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

}  // namespace dccast::relay
