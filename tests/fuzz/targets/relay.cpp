// What a peer sends over a connection, and what gRPC answers it, as the relay follows both.
#include <algorithm>

#include "server/relay/frame_guard.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using dccast::fuzz::require;
using dccast::relay::FrameGuard;

constexpr std::string_view preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";
constexpr std::size_t most_of_call = 20'000;

/// What the relay makes of a conversation.
struct Outcome {
  std::string forwarded;
  bool ended = false;
  std::size_t unfinished = 0, resets = 0;
  bool operator==(const Outcome&) const = default;
};

/// @param piece  bytes that come at once
Outcome carry(std::string_view requests, std::string_view answers, std::size_t piece) {
  FrameGuard guard("42", most_of_call);
  const FrameGuard::Clock::time_point now{};
  Outcome outcome;
  for (std::string_view rest = requests; !rest.empty() && !outcome.ended;) {
    outcome.ended = !guard.take(rest.substr(0, piece), now, outcome.forwarded).empty();
    rest.remove_prefix(std::min(piece, rest.size()));
  }
  for (std::string_view rest = answers; !rest.empty() && !outcome.ended;) {
    guard.take_answer(rest.substr(0, piece));
    rest.remove_prefix(std::min(piece, rest.size()));
  }
  outcome.unfinished = guard.unfinished_bytes();
  outcome.resets = guard.take_resets();
  return outcome;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  std::string_view text = dccast::fuzz::text_of(bytes, size);
  const std::size_t piece = 1 + dccast::fuzz::take_choice(text) % 64;
  const std::size_t of_answers =
      std::min<std::size_t>(dccast::fuzz::take_choice(text), text.size());
  const std::string_view answers = text.substr(0, of_answers);
  const std::string requests = std::string(preface) + std::string(text.substr(of_answers));

  const Outcome whole = carry(requests, answers, requests.size());
  const Outcome in_pieces = carry(requests, answers, piece);
  require(whole.ended == in_pieces.ended, "it does not depend on the cuts what is hostile");
  if (!whole.ended) require(whole == in_pieces, "nor what is forwarded and counted");
  require(whole.unfinished <= size * most_of_call + 9'000 * size, "what is held has a bound");
  require(whole.forwarded.size() <= requests.size() + 64 * requests.size(),
          "what is forwarded is little longer");
  return 0;
}
