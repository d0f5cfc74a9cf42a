#include "server/relay/frame_guard.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <string>

namespace dccast::relay {

namespace {

using namespace std::chrono_literals;

enum Kind : char {
  data,
  headers,
  priority,
  rst_stream,
  settings,
  ping = 6,
  window_update = 8,
  continuation
};
constexpr char end_stream = 1, end_headers = 4;
const std::string preface = "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n";

std::string frame(Kind kind, char flags, std::uint32_t stream, std::size_t size = 0) {
  const auto byte = [](std::size_t value, int place) {
    return static_cast<char>(value >> (8 * place) & 0xff);
  };
  std::string whole{byte(size, 2), byte(size, 1), byte(size, 0), kind, flags};
  for (int place = 3; place >= 0; --place) whole += byte(stream, place);
  return whole + std::string(size, 'x');
}

std::string begin(std::uint32_t stream) {
  return frame(headers, end_headers, stream, 60);
}

std::string call(std::uint32_t stream) {
  return begin(stream) + frame(data, end_stream, stream, 5);
}

struct FrameGuardTest : testing::Test {
  FrameGuard guard{"42"};
  std::string forwarded;
  FrameGuard::Clock::time_point now = FrameGuard::Clock::now();

  void SetUp() override { send(preface + frame(settings, 0, 0, 18) + frame(settings, 1, 0)); }
  std::string send(const std::string& bytes) {
    return std::string(guard.take(bytes, now, forwarded));
  }

  /// Number of these calls that pass at this instant.
  int number_taken(const std::string& bytes, int most) {
    int taken = 0;
    while (taken < most && send(bytes).empty()) ++taken;
    return taken;
  }
};

TEST_F(FrameGuardTest, ABusyClientPasses) {
  std::uint32_t stream = 1;
  for (int second = 0; second < 30; ++second, now += 1s)
    for (int i = 0; i < 1000; ++i, stream += 2)
      ASSERT_EQ(send(call(stream) + frame(window_update, 0, stream, 4)), "");
}

TEST_F(FrameGuardTest, OneWhoDoesNotAcknowledgeTheBoundOnCallsBeginsFew) {
  FrameGuard silent;
  EXPECT_EQ(silent.take(preface + frame(settings, 0, 0, 18), now, forwarded), "");
  int taken = 0;
  while (taken < 1000 && silent.take(call(1), now, forwarded).empty()) ++taken;
  EXPECT_EQ(taken, 100);
}

TEST_F(FrameGuardTest, ACallWithoutARequestHoldsMemoryToo) {
  for (std::uint32_t stream = 1; stream < 200; stream += 2)
    EXPECT_EQ(send(frame(headers, end_headers, stream, 60)), "");
  EXPECT_GE(guard.unfinished_bytes(), 100U * 4096U);
}

TEST_F(FrameGuardTest, CallsThatAreTakenBackAreBounded) {
  EXPECT_EQ(number_taken(call(1) + frame(rst_stream, 0, 1, 4), 5000), 2000);
}

TEST_F(FrameGuardTest, AsManyAsAConnectionHasOpenMayBeTakenBackAgainLater) {
  EXPECT_EQ(number_taken(frame(rst_stream, 0, 1, 4), 2000), 2000);
  now += 2s;
  EXPECT_EQ(number_taken(frame(rst_stream, 0, 1, 4), 2000), 2000);
}

TEST_F(FrameGuardTest, FramesAreFollowedWhereverTheBytesAreCut) {
  for (const char byte : call(1)) ASSERT_EQ(send({byte}), "");
  const std::string reset = frame(rst_stream, 0, 1, 4);
  int taken = 0;
  for (; taken < 10000; ++taken) {
    bool passed = true;
    for (const char byte : reset) passed = passed && send({byte}).empty();
    if (!passed) break;
  }
  EXPECT_EQ(taken, 2000);
}

/// Headers of a call as gRPC sees them, with the number of this connection.
std::string with_connection(std::uint32_t stream, const std::string& headers_without_end) {
  std::string field("\0\x11", 2);
  field.append("dccast-connection").append("\x02").append("42");
  std::string ours = frame(continuation, end_headers, stream, field.size());
  return headers_without_end + ours.replace(9, field.size(), field);
}

TEST_F(FrameGuardTest, EachCallGetsTheNumberOfItsConnectionBehindItsHeaders) {
  const std::string body = frame(data, end_stream, 1, 5);
  forwarded.clear();
  EXPECT_EQ(send(frame(headers, end_headers, 1, 60) + body), "");
  EXPECT_EQ(forwarded, with_connection(1, frame(headers, 0, 1, 60)) + body);

  forwarded.clear();
  const std::string in_pieces =
      frame(headers, end_stream, 3, 60) + frame(continuation, end_headers, 3, 0);
  for (const char byte : in_pieces) EXPECT_EQ(send({byte}), "");
  EXPECT_EQ(forwarded,
            with_connection(3, frame(headers, end_stream, 3, 60) + frame(continuation, 0, 3, 0)));
}

TEST_F(FrameGuardTest, OtherFramesPassAsTheyAre) {
  const std::string others = frame(settings, 1, 0) + frame(ping, 0, 0, 8) +
                             frame(window_update, 0, 1, 4) + frame(rst_stream, 0, 1, 4);
  forwarded.clear();
  EXPECT_EQ(send(others), "");
  EXPECT_EQ(forwarded, others);
}

TEST_F(FrameGuardTest, HeadersEnd) {
  EXPECT_EQ(send(frame(headers, 0, 1, 16384)), "");
  EXPECT_EQ(number_taken(frame(continuation, 0, 1, 16384), 100), 3);
}

TEST_F(FrameGuardTest, EmptyPiecesOfHeadersAreBounded) {
  EXPECT_EQ(send(frame(headers, 0, 1, 10)), "");
  EXPECT_LT(number_taken(frame(continuation, 0, 1), 5000), 2000);
}

TEST_F(FrameGuardTest, FramesThatBringNothingAreBounded) {
  EXPECT_EQ(send(begin(1)), "");
  EXPECT_LT(number_taken(frame(data, 0, 1), 5000), 2000);
  EXPECT_GT(number_taken(frame(data, end_stream, 1), 10), 0);
  now += 60s;
  EXPECT_LT(number_taken(frame(ping, 0, 0, 8), 5000), 2000);
  EXPECT_LT(number_taken(frame(window_update, 0, 0, 4), 100000), 50000);
}

TEST_F(FrameGuardTest, UnfinishedBytesAreThoseOfCallsThatHaveNotEnded) {
  EXPECT_EQ(send(begin(1) + begin(3)), "");
  const std::size_t begun = guard.unfinished_bytes() / 2;
  EXPECT_EQ(send(frame(data, 0, 1, 10000) + frame(data, 0, 3, 20000)), "");
  EXPECT_NEAR(static_cast<double>(guard.unfinished_bytes() - 2 * begun), 30000.0, 1000.0);
  EXPECT_EQ(send(frame(data, end_stream, 3, 7)), "");
  EXPECT_NEAR(static_cast<double>(guard.unfinished_bytes() - begun), 10000.0, 1000.0);
  EXPECT_EQ(send(frame(rst_stream, 0, 1, 4)), "");
  EXPECT_EQ(guard.unfinished_bytes(), 0U);
}

/// gRPC reads no further before the call has taken what came: an upload may be of any size.
TEST_F(FrameGuardTest, OfTheContentOfACallNoMoreCountsThanGrpcHolds) {
  FrameGuard bounded("42", 50000);
  const auto give = [&](const std::string& bytes) {
    EXPECT_EQ(bounded.take(bytes, now, forwarded), "");
    return static_cast<double>(bounded.unfinished_bytes());
  };
  const double begun = give(preface + begin(1) + begin(3));

  double held = 0.0;
  for (int i = 0; i < 100; ++i) held = give(frame(data, 0, 1, 16000));
  EXPECT_NEAR(held - begun, 50000.0, 10000.0);
  give(frame(data, 0, 3, 20000));
  EXPECT_NEAR(give(frame(data, end_stream, 1)), 20000.0 + begun / 2.0, 1000.0);

  // Small pieces take what gRPC keeps around each, without that bound.
  for (int i = 0; i < 10000; ++i) held = give(frame(data, 0, 3, 1));
  EXPECT_GE(held, 640000.0);
}

TEST_F(FrameGuardTest, ABodyInSmallPiecesCountsWhatGrpcKeepsOfThem) {
  EXPECT_EQ(send(begin(1)), "");
  for (int i = 0; i < 1000; ++i) EXPECT_EQ(send(frame(data, 0, 1, 1)), "");
  EXPECT_GE(guard.unfinished_bytes(), 32000U);
}

TEST_F(FrameGuardTest, TheRequestOfACallThatWasNeverBegunIsHostile) {
  EXPECT_EQ(send(begin(5)), "");
  EXPECT_NE(send(frame(data, 0, 7, 1)), "");
}

TEST_F(FrameGuardTest, WhatComesForACallThatHasEndedHoldsNothing) {
  EXPECT_EQ(send(call(1) + begin(3) + frame(rst_stream, 0, 3, 4)), "");
  for (int i = 0; i < 1000; ++i)
    EXPECT_EQ(send(frame(data, 0, 1, 1) + frame(data, 0, 3, 1) + begin(1)), "");
  EXPECT_EQ(guard.unfinished_bytes(), 0U);
}

TEST_F(FrameGuardTest, ACallThatTheServerHasEndedHoldsNothing) {
  EXPECT_EQ(send(begin(1) + begin(3) + frame(data, 0, 1, 5000) + frame(data, 0, 3, 5000)), "");
  const std::string answers =
      frame(settings, 0, 0, 18) + frame(headers, end_headers, 1, 30) + frame(data, 0, 1, 70) +
      frame(headers, end_headers | end_stream, 1, 30) + frame(rst_stream, 0, 3, 4);
  for (const char byte : answers) guard.take_answer({&byte, 1});
  EXPECT_EQ(guard.unfinished_bytes(), 0U);
  EXPECT_EQ(send(frame(data, 0, 1, 5000) + frame(data, 0, 3, 5000)), "");
  EXPECT_EQ(guard.unfinished_bytes(), 0U);
}

/// gRPC begins no call with an even number, and must not be made to begin one that is not counted.
TEST_F(FrameGuardTest, NumbersOfTheServerAreHostile) {
  EXPECT_NE(send(begin(2)), "");
}

}  // namespace

}  // namespace dccast::relay
