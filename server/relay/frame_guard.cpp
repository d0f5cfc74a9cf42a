#include "server/relay/frame_guard.hpp"

#include <algorithm>
#include <utility>

#include "server/relay/peer_table.hpp"

namespace dccast::relay {

namespace {

constexpr std::size_t preface_bytes = 24;
// gRPC accepts 8 kB of metadata, but reads longer metadata to its end, however long.
constexpr std::size_t most_of_a_header_block = 64 * 1024;
// gRPC keeps a slice and a list node for each frame of a body, beside its bytes.
constexpr std::size_t kept_per_frame = 64;
constexpr std::size_t kept_per_call = 8 * 1024;
// Once a client has acknowledged the settings, gRPC itself bounds its calls.
constexpr int most_begun_before_acknowledgement = 100;

/// HPACK literal header field that is not indexed (RFC 7541, 6.2.2), without Huffman coding. It
/// neither needs nor changes the dynamic table.
std::string literal_field(std::string_view name, std::string_view value) {
  std::string field(1, '\0');
  for (const std::string_view text : {name, value}) {
    field += static_cast<char>(text.size());  // below 127: one byte
    field += text;
  }
  return field;
}

}  // namespace

FrameGuard::FrameGuard(std::string_view connection, std::size_t most_of_call)
    : requests_(preface_bytes),
      answers_(0),
      connection_field_(literal_field(connection_header, connection)),
      most_of_call_(most_of_call) {}

std::string_view FrameGuard::take(std::string_view bytes, Clock::time_point now,
                                  std::string& forwarded) {
  for (;;) {
    forwarded += requests_.take_payload(bytes);
    if (requests_.at_end_of_payload() && needs_connection_) forward_connection_header(forwarded);
    if (bytes.empty()) return {};

    const auto frame = requests_.take_head(bytes);
    if (!frame) return {};
    if (const auto fault = judge(*frame, now); !fault.empty()) return fault;
    forward_head(*frame, forwarded);
  }
}

void FrameGuard::take_answer(std::string_view bytes) {
  while (!bytes.empty()) {
    answers_.take_payload(bytes);
    const auto frame = answers_.take_head(bytes);
    if (!frame) continue;

    const bool has_content = frame->kind == Frame::headers || frame->kind == Frame::data;
    if (frame->kind == Frame::rst_stream) ++resets_counted_;
    if (frame->kind == Frame::rst_stream || (has_content && frame->flags & Frame::end_stream))
      forget(frame->stream);
  }
}

void FrameGuard::forward_head(Frame frame, std::string& forwarded) {
  // Clear END_HEADERS: a continuation frame of the relay follows with the connection header.
  if ((frame.kind == Frame::headers || frame.kind == Frame::continuation) &&
      frame.flags & Frame::end_headers) {
    frame.flags = static_cast<std::uint8_t>(frame.flags & ~Frame::end_headers);
    needs_connection_ = frame.stream;
  }
  const Frame::Head head = frame.head();
  forwarded.append(head.begin(), head.end());
}

void FrameGuard::forward_connection_header(std::string& forwarded) {
  const Frame frame{.kind = Frame::continuation,
                    .flags = Frame::end_headers,
                    .stream = *std::exchange(needs_connection_, std::nullopt),
                    .size = connection_field_.size()};
  const Frame::Head head = frame.head();
  forwarded.append(head.begin(), head.end());
  forwarded += connection_field_;
}

std::string_view FrameGuard::judge(const Frame& frame, Clock::time_point now) {
  switch (frame.kind) {
    case Frame::headers:
      header_block_ = 0;
      if (!begun_.take(now)) return "it begins calls without end";
      if (!acknowledged_ && ++begun_before_acknowledgement_ > most_begun_before_acknowledgement)
        return "it begins calls without acknowledging the bound on them";
      return take_headers(frame);

    case Frame::continuation:
      if (!others_.take(now)) return "it sends headers in small pieces";
      return take_headers(frame);

    case Frame::data:
      if (frame.size == 0 && !(frame.flags & Frame::end_stream) && !others_.take(now))
        return "it sends empty frames";
      return take_body(frame);

    case Frame::rst_stream:
      ++resets_counted_;
      forget(frame.stream);
      return resets_.take(now) ? "" : "it takes back its calls";

    case Frame::window_update:
      return updates_.take(now) ? "" : "it updates windows without end";

    case Frame::settings:
      acknowledged_ = acknowledged_ || frame.flags & Frame::acknowledgement;
      [[fallthrough]];
    default:
      return others_.take(now) ? "" : "it sends pings or settings without end";
  }
}

std::string_view FrameGuard::take_headers(const Frame& frame) {
  // Headers of a call that is open already end its request.
  if (frame.kind == Frame::headers) {
    if (frame.stream % 2 == 0) return "it begins calls with numbers of the server";
    const bool begins = frame.stream > last_begun_;
    last_begun_ = std::max(last_begun_, frame.stream);
    if (frame.flags & Frame::end_stream)
      forget(frame.stream);
    else if (begins)
      keep(frame.stream, {.around = kept_per_call});
  }
  header_block_ += frame.size;
  return header_block_ > most_of_a_header_block ? "its headers are too long" : "";
}

std::string_view FrameGuard::take_body(const Frame& frame) {
  if (frame.stream > last_begun_) return "it sends the request of a call that was not begun";
  if (frame.flags & Frame::end_stream) {
    forget(frame.stream);
  } else if (unfinished_.contains(frame.stream)) {
    // gRPC throws away what comes for a call that has ended.
    keep(frame.stream, {.content = frame.size, .around = kept_per_frame});
  }
  return {};
}

std::size_t FrameGuard::held(const Unfinished& request) const {
  return std::min(request.content, most_of_call_) + request.around;
}

void FrameGuard::keep(std::uint32_t stream, const Unfinished& more) {
  Unfinished& request = unfinished_[stream];
  unfinished_bytes_ -= held(request);
  request.content += more.content;
  request.around += more.around;
  unfinished_bytes_ += held(request);
}

void FrameGuard::forget(std::uint32_t stream) {
  const auto found = unfinished_.find(stream);
  if (found == unfinished_.end()) return;
  unfinished_bytes_ -= held(found->second);
  unfinished_.erase(found);
}

}  // namespace dccast::relay
