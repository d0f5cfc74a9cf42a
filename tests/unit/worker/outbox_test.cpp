#include "server/worker/outbox.hpp"

#include <gmock/gmock.h>

#include <string>

#include "tests/unit/worker/worker_messages.hpp"

namespace dccast::worker {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

v1::WorkerMessage finding(const std::string& code) {
  v1::WorkerMessage message;
  message.mutable_finding()->set_code(code);
  return message;
}

v1::WorkerMessage finished() {
  v1::WorkerMessage message;
  message.mutable_finished()->set_outcome(v1::WorkerMessage::Finished::SUCCEEDED);
  return message;
}

std::vector<std::string> words(const std::vector<v1::WorkerMessage>& messages) {
  std::vector<std::string> words;
  for (const auto& message : messages)
    words.push_back(message.has_step()      ? std::to_string(message.step().step())
                    : message.has_finding() ? message.finding().code()
                                            : "finished");
  return words;
}

/// Steps 1 and 2, a finding, step 3: all sent.
Outbox three_steps_and_a_finding() {
  Outbox outbox;
  outbox.keep(true);
  for (const auto& message : {step(1), step(2), finding("a"), step(3)}) outbox.add(message);
  outbox.take();
  return outbox;
}

TEST(Outbox, GivesEachMessageOnce) {
  Outbox outbox;
  outbox.add(step(1));
  EXPECT_THAT(words(outbox.take()), ElementsAre("1"));
  outbox.add(step(2));
  EXPECT_THAT(words(outbox.take()), ElementsAre("2"));
  EXPECT_FALSE(outbox.has_unsent());
}

TEST(Outbox, SaysAgainWhatTheNextDaemonLacks) {
  auto outbox = three_steps_and_a_finding();
  ASSERT_TRUE(outbox.rewind(1));
  EXPECT_THAT(words(outbox.take()), ElementsAre("2", "a", "3"));
  ASSERT_TRUE(outbox.rewind(3));
  EXPECT_THAT(words(outbox.take()), IsEmpty());
}

// Whether the daemon had stored the finding when it died, nobody knows: it takes it once.
TEST(Outbox, SaysAgainWhatCameAfterTheLastReport) {
  auto outbox = three_steps_and_a_finding();
  ASSERT_TRUE(outbox.rewind(2));
  EXPECT_THAT(words(outbox.take()), ElementsAre("a", "3"));
}

TEST(Outbox, ForgetsWhatIsStoredAndRefusesToGoBehindIt) {
  auto outbox = three_steps_and_a_finding();
  outbox.forget_stored(2);
  EXPECT_FALSE(outbox.rewind(1)) << "step 2 is no longer here";
  EXPECT_FALSE(outbox.rewind(4)) << "that was never said";
  ASSERT_TRUE(outbox.rewind(2));
  EXPECT_THAT(words(outbox.take()), ElementsAre("a", "3"));
}

TEST(Outbox, ForgetsNothingThatWasNotSent) {
  auto outbox = three_steps_and_a_finding();
  outbox.add(step(4));
  outbox.forget_stored(9);
  EXPECT_THAT(words(outbox.take()), ElementsAre("4"));
}

TEST(Outbox, SaysItsLastWordToEveryDaemon) {
  auto outbox = three_steps_and_a_finding();
  outbox.add(finished());
  EXPECT_FALSE(outbox.said_last_word());
  outbox.take();
  EXPECT_TRUE(outbox.said_last_word());
  outbox.forget_stored(3);
  ASSERT_TRUE(outbox.rewind(3));
  EXPECT_FALSE(outbox.said_last_word());
  EXPECT_THAT(words(outbox.take()), ElementsAre("finished"));
}

TEST(Outbox, IsFullWithManyMessagesAndWithLargeOnes) {
  Outbox many;
  many.keep(true);
  for (int i = 0; i < 4096; ++i) many.add(step(i));
  EXPECT_TRUE(many.is_full());
  many.take();
  EXPECT_TRUE(many.is_full());
  many.forget_stored(1);
  EXPECT_FALSE(many.is_full());
  Outbox large;
  large.add(finding(std::string(64 << 20, 'x')));
  EXPECT_TRUE(large.is_full());
  large.take();
  EXPECT_FALSE(large.is_full()) << "a worker that ends with its daemon keeps nothing";
}

}  // namespace
}  // namespace dccast::worker
