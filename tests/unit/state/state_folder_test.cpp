#include "server/state/state_folder.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <thread>

#include "tests/support/temporary_folder.hpp"

namespace dccast::state {
namespace {

using namespace std::chrono_literals;

// A process that a killed daemon was about to start holds the lock until it gets the processor.
TEST(StateLock, WaitsForOneThatIsAboutToBeGivenUp) {
  const TemporaryFolder temporary;
  const StateFolder folder(temporary.path());
  auto held = std::make_unique<StateLock>(folder);
  const std::jthread giver([&held] {
    std::this_thread::sleep_for(200ms);  // the other waits by then
    held.reset();
  });
  EXPECT_NO_THROW(StateLock{folder});
}

TEST(StateLock, RefusesADirectoryThatIsInUse) {
  const TemporaryFolder temporary;
  const StateFolder folder(temporary.path());
  const StateLock held(folder);
  try {
    StateLock{folder};
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("another dccastd"), std::string::npos);
  }
}

}  // namespace
}  // namespace dccast::state
