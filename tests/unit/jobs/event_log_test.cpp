#include "server/jobs/logs/event_log.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <cstdlib>
#include <fstream>
#include <new>
#include <optional>
#include <random>
#include <set>

#include "server/jobs/folder/events.hpp"
#include "server/jobs/logs/event_logs.hpp"
#include "tests/support/eventually.hpp"
#include "tests/support/temporary_folder.hpp"
#include "tests/unit/jobs/failing_sync.hpp"

namespace {
/// Allocations of this thread that still succeed; empty: all.
thread_local std::optional<int> allocations_left;
}  // namespace

void* operator new(std::size_t size) {
  const bool succeeds = !allocations_left || (*allocations_left)-- > 0;
  void* memory = succeeds ? std::malloc(size) : nullptr;
  return memory != nullptr ? memory : throw std::bad_alloc();
}
// Inlined, GCC takes them for the wrong partners of a `new` that is not.
[[gnu::noinline]] void operator delete(void* memory) noexcept {
  std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}

namespace dccast::jobs {
namespace {

namespace fs = std::filesystem;

v1::JobEvent step_event(std::int64_t step) {
  v1::JobEvent event;
  event.mutable_step()->set_step(step);
  return event;
}

void append_steps(EventLog& log, std::int64_t first, std::int64_t last) {
  for (std::int64_t step = first; step <= last; ++step) {
    auto event = step_event(step);
    log.append(event);
  }
}

std::vector<v1::JobEvent> all_events(const EventLog& log, std::int64_t from = 1) {
  std::vector<v1::JobEvent> events;
  EventLog::Cursor cursor{.sequence = from};
  while (auto event = log.read(cursor)) events.push_back(*event);
  return events;
}

void write(const fs::path& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary) << bytes;
}

void overwrite(const fs::path& path, std::uintmax_t offset, const std::string& bytes) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(static_cast<std::streamoff>(offset));
  file << bytes;
}

class EventLogTest : public testing::Test {
protected:
  fs::path path() const { return folder_.path() / "events.log"; }

  /// 49 steps and an end; ends_ keeps the byte behind each record.
  std::string log_of_fifty_events() {
    EventLog log(path());
    for (int step = 1; step <= 49; ++step) {
      append_steps(log, step, step);
      ends_.push_back(fs::file_size(path()));
    }
    v1::Job job;
    job.set_state(v1::SUCCEEDED);
    v1::JobEvent end = state_event({.job = job}, "finished");
    log.append(end);
    ends_.push_back(fs::file_size(path()));
    std::ifstream file(path(), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  /// Sequence of the event a byte belongs to; 0 for the header.
  std::int64_t event_at(std::size_t byte) const {
    if (byte < 16) return 0;
    return std::ranges::upper_bound(ends_, byte) - ends_.begin() + 1;
  }

  TemporaryFolder folder_;
  std::vector<std::uintmax_t> ends_;
};

TEST_F(EventLogTest, GivesBackWhatWasAppendedAlsoAfterOpeningAgain) {
  {
    EventLog log(path());
    append_steps(log, 1, 300);
    EXPECT_EQ(log.last_sequence(), 300);
  }
  EventLog log(path());
  append_steps(log, 301, 310);
  const auto events = all_events(log);

  ASSERT_EQ(events.size(), 310u);
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].sequence(), static_cast<std::int64_t>(i) + 1);
    EXPECT_EQ(events[i].step().step(), static_cast<std::int64_t>(i) + 1);
    EXPECT_TRUE(events[i].has_time());
  }
}

TEST_F(EventLogTest, ACursorBeginsAnywhere) {
  EventLog log(path());
  append_steps(log, 1, 200);
  for (const std::int64_t from : {1, 2, 63, 64, 65, 66, 128, 129, 200}) {
    const auto events = all_events(log, from);
    ASSERT_EQ(static_cast<std::int64_t>(events.size()), 201 - from);
    EXPECT_EQ(events.front().sequence(), from);
  }
  EventLog::Cursor next{.sequence = 201};
  EXPECT_FALSE(log.read(next));
  append_steps(log, 201, 201);
  EXPECT_EQ(log.read(next)->step().step(), 201);
}

// A file cut at any length keeps its whole events, and numbering continues.
TEST_F(EventLogTest, ATornTailIsCutOffWhereverItWasTorn) {
  std::uintmax_t before = 0;
  {
    EventLog log(path());
    append_steps(log, 1, 2);
    before = fs::file_size(path());
    append_steps(log, 3, 3);
  }
  for (auto size = before; size < fs::file_size(path()); ++size) {
    const auto torn = folder_.path() / ("torn" + std::to_string(size));
    fs::copy(path(), torn);
    fs::resize_file(torn, size);
    EventLog log(torn);
    EXPECT_EQ(log.last_sequence(), 2) << size;
    append_steps(log, 7, 7);
    EXPECT_EQ(all_events(log).back().sequence(), 3);
    EXPECT_EQ(all_events(log).back().step().step(), 7);
  }
}

TEST_F(EventLogTest, ADamagedRecordEndsTheLog) {
  {
    EventLog log(path());
    append_steps(log, 1, 3);
  }
  {
    std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(-1, std::ios::end);
    file.put('\x7f');
  }
  EXPECT_EQ(EventLog(path()).last_sequence(), 2);
}

// A flipped bit costs the event it is in and no other, wherever it is: in the header, in the
// length, the checksum or the payload of any record.
TEST_F(EventLogTest, AFlippedBitCostsNoEventButItsOwn) {
  const std::string sound = log_of_fifty_events();
  std::mt19937_64 random(20261121);
  for (int trial = 0; trial < 600; ++trial) {
    const auto bit = std::uniform_int_distribution<std::size_t>(0, sound.size() * 8 - 1)(random);
    SCOPED_TRACE("bit " + std::to_string(bit % 8) + " of byte " + std::to_string(bit / 8));
    std::string damaged = sound;
    damaged[bit / 8] = static_cast<char>(damaged[bit / 8] ^ (1 << bit % 8));
    write(path(), damaged);
    const std::int64_t lost = event_at(bit / 8);
    EventLog log(path());
    ASSERT_EQ(log.last_sequence(), lost == 50 ? 49 : 50);
    ASSERT_EQ(log.terminal_event().has_value(), lost != 50);
    for (const v1::JobEvent& event : all_events(log))
      ASSERT_EQ(event.has_message(), event.sequence() == lost) << event.ShortDebugString();
    if (HasFatalFailure()) return;
  }
}

TEST_F(EventLogTest, ALogWithDamageGoesOnAndSaysWhatIsLost) {
  {
    EventLog log(path());
    append_steps(log, 1, 200);
  }
  overwrite(path(), fs::file_size(path()) / 2, std::string(60, 'x'));
  std::int64_t lost = 0;
  for (int opened = 0; opened < 2; ++opened) {
    EventLog log(path());
    append_steps(log, 201 + opened, 201 + opened);
    ASSERT_EQ(log.content().gaps.size(), 1u);
    lost = log.content().gaps[0].first;
    const auto events = all_events(log);
    ASSERT_EQ(events.size(), 201u + static_cast<std::size_t>(opened));
    for (std::size_t i = 0; i < events.size(); ++i) {
      const auto sequence = static_cast<std::int64_t>(i) + 1;
      EXPECT_EQ(events[i].sequence(), sequence);
      EXPECT_TRUE(events[i].has_time());
      if (events[i].has_step()) {
        EXPECT_EQ(events[i].step().step(), sequence);
      }
    }
    EXPECT_EQ(events[static_cast<std::size_t>(lost) - 1].message().level(),
              v1::JobEvent::Message::WARNING);
    for (std::int64_t from = lost - 2; from < lost + 70; ++from)
      EXPECT_EQ(all_events(log, from).front().sequence(), from);
  }
}

/// Right checksums do not make an event: a program that writes odd records, or a file put together
/// by hand.
class OddEventLogTest : public EventLogTest {
protected:
  static std::string record(const std::string& payload) {
    return storage::short_records.framed(payload);
  }
  static std::string event(std::int64_t sequence) {
    auto step = step_event(sequence);
    step.set_sequence(sequence);
    return record(step.SerializeAsString());
  }
  EventLogContent scan_of(const std::string& records) {
    write(path(), event_log_header() + records);
    return scan_event_log(path());
  }
};

TEST_F(OddEventLogTest, ASequenceBehindARecordIsNotOfIt) {
  // The head of the second record would end its number: it is 0x08 alone, then 2 as a length.
  const auto content = scan_of(event(1) + record("\x08") + record("\x08\x03") + event(2));
  EXPECT_EQ(content.last_sequence, 3);
  ASSERT_EQ(content.gaps.size(), 1u);
  EXPECT_EQ(content.gaps[0].first, 2);
  EXPECT_EQ(content.gaps[0].last, 2);
  EXPECT_LT(content.gaps[0].begin, content.gaps[0].end);
}

TEST_F(OddEventLogTest, ARecordThatIsNoEventOfItsNumberIsDamage) {
  const std::string twice = "\x08\x02\x08\x63", cut = "\x08\x02\x1a\x7f";
  for (const std::string& odd : {twice, cut}) {
    const auto content = scan_of(event(1) + record(odd) + event(3));
    EXPECT_EQ(content.last_sequence, 3);
    ASSERT_EQ(content.gaps.size(), 1u);
    EXPECT_EQ(content.gaps[0].first, 2);
    EXPECT_EQ(content.gaps[0].last, 2);
    const auto events = all_events(EventLog(path()));
    ASSERT_EQ(events.size(), 3u);
    EXPECT_TRUE(events[1].has_message());
  }
}

TEST_F(OddEventLogTest, MissingEventsAreAGapWithoutBytes) {
  const auto content = scan_of(event(1) + event(4));
  ASSERT_EQ(content.gaps.size(), 1u);
  EXPECT_EQ(content.gaps[0].description(), "events 2 to 3 are lost: they are missing at byte " +
                                               std::to_string(content.gaps[0].begin) +
                                               " of the event log");
  EXPECT_EQ(all_events(EventLog(path())).size(), 4u);
}

TEST_F(EventLogTest, ADamagedEndIsKeptAsideAndATornOneIsNot) {
  {
    EventLog log(path());
    append_steps(log, 1, 3);
  }
  overwrite(path(), fs::file_size(path()) - 1, "\x7f");
  EventLog(path()).take_over();
  const auto aside = path().string() + ".damaged-" + std::to_string(fs::file_size(path()));
  EXPECT_TRUE(fs::exists(aside));
  fs::remove(aside);
  fs::resize_file(path(), fs::file_size(path()) - 1);
  EXPECT_EQ(EventLog(path()).last_sequence(), 1);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_.path()), {}), 1);
}

TEST_F(EventLogTest, RefusesAFileThatIsNone) {
  std::ofstream(path()) << "this is some other file, and a long one";
  EXPECT_THROW(EventLog{path()}, std::runtime_error);
}

TEST_F(EventLogTest, TakesNothingAfterItsEnd) {
  EventLog log(path());
  v1::Job job;
  job.set_state(v1::CANCELLED);
  v1::JobEvent end = state_event({.job = job}, "enough");
  log.append(end);
  EXPECT_EQ(log.terminal_event()->state_change().cause(), "enough");
  EXPECT_THROW(append_steps(log, 1, 1), std::logic_error);
  EXPECT_TRUE(EventLog(path()).terminal_event());
}

// The limit on a file's size stands for a full disk: a part of the record is written, then no more.
TEST_F(EventLogTest, AFailedAppendLeavesTheLogAsItWas) {
  ::signal(SIGXFSZ, SIG_IGN);
  EventLog log(path());
  append_steps(log, 1, 5);
  rlimit before;
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);

  const rlimit tight{fs::file_size(path()) + 5, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &tight), 0);
  EXPECT_THROW(append_steps(log, 6, 6), std::system_error);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_EQ(log.last_sequence(), 5);
  EXPECT_EQ(EventLog(path()).last_sequence(), 5);

  append_steps(log, 6, 6);
  EXPECT_EQ(all_events(log).size(), 6u);
}

// A run must not go on behind records that may be lost; who takes the log over writes them again.
TEST_F(EventLogTest, AfterAFailedSyncItIsTakenOverAgain) {
  EventLog log(path());
  append_steps(log, 1, 5);
  {
    const FailingSync failing;
    EXPECT_THROW(log.sync(), std::system_error);
  }
  EXPECT_THROW(append_steps(log, 6, 6), std::system_error);
  log.take_over();
  append_steps(log, 6, 6);
  log.sync();
  EXPECT_EQ(EventLog(path()).last_sequence(), 6);
}

TEST_F(EventLogTest, KnowsTheLastStepThatWasNotTakenBack) {
  EventLog log(path());
  append_steps(log, 1, 7);
  v1::JobEvent resumed;
  resumed.mutable_resumed()->set_step(5);
  log.append(resumed);
  EXPECT_FALSE(log.content().last_step);
  append_steps(log, 6, 8);
  append_steps(log, 1, 2);  // begun again without a checkpoint
  EXPECT_EQ(log.content().last_step->step(), 2);
}

class CountingWatcher : public Watcher {
public:
  void on_appended() override { ++calls; }
  std::atomic<int> calls{0};
};

v1::JobEvent running_event() {
  v1::JobEvent event;
  event.mutable_state_change()->set_state(v1::RUNNING);
  return event;
}

v1::JobEvent run_end_event(int attempt) {
  v1::JobEvent event;
  event.mutable_run_ended()->set_outcome(v1::RunEnd::SUCCEEDED);
  event.mutable_run_ended()->set_attempt(attempt);
  return event;
}

TEST_F(EventLogTest, AReaderTakesWhatAnotherProcessAppends) {
  EventLog reader(path());
  append_steps(reader, 1, 2);
  reader.hand_over();
  EXPECT_FALSE(reader.refresh());
  EventLog writer(path());
  append_steps(writer, 3, 400);
  EXPECT_TRUE(reader.refresh());
  EXPECT_EQ(reader.content().reached_step, 400);
  EXPECT_EQ(all_events(reader).size(), 400u);
  append_steps(reader, 401, 401);  // takes over
  EXPECT_EQ(EventLog(path()).last_sequence(), 401);
}

// The writer was killed in the middle of a record: a reader waits for the rest of it, and the next
// writer cuts it off.
TEST_F(EventLogTest, WhatAKilledWriterLeftIsCutOffByTheNextOne) {
  EventLog reader(path());
  append_steps(reader, 1, 1);
  reader.hand_over();
  append_steps(*std::make_unique<EventLog>(path()), 2, 3);
  fs::resize_file(path(), fs::file_size(path()) - 1);
  const auto torn = fs::file_size(path());
  EXPECT_TRUE(reader.refresh());
  EXPECT_EQ(reader.last_sequence(), 2);
  EXPECT_EQ(fs::file_size(path()), torn) << "a reader changes nothing";
  append_steps(reader, 3, 3);
  EXPECT_EQ(all_events(EventLog(path())).size(), 3u);
}

TEST_F(EventLogTest, KnowsHowTheLastAttemptHasEnded) {
  EventLog log(path());
  auto event = running_event();
  log.append(event);
  EXPECT_FALSE(log.content().run_end);
  event = run_end_event(1);
  log.append(event);
  EXPECT_EQ(EventLog(path()).content().run_end->attempt(), 1);
  event = running_event();
  log.append(event);
  EXPECT_FALSE(log.content().run_end) << "of an attempt before";
  EXPECT_EQ(EventLog(path()).content().attempts, 2);
}

TEST_F(EventLogTest, APreparedEventIsInTheFileAndNotYetSeen) {
  EventLog log(path());
  append_steps(log, 1, 1);
  auto event = running_event();
  log.prepare(event);
  EXPECT_EQ(log.last_sequence(), 1);
  EXPECT_EQ(EventLog(path()).last_sequence(), 2);
  log.announce();
  EXPECT_EQ(log.last_sequence(), 2);
  log.prepare(event);
  log.hand_over();  // it is not to be
  EXPECT_EQ(EventLog(path()).last_sequence(), 2);
}

TEST_F(EventLogTest, TellsAJobThatItsModelHasStoppedBeingValid) {
  {
    EventLog log(path());
    v1::JobEvent event;
    event.mutable_validity_lost()->set_time_s(7.0);
    log.append(event);
  }
  const EventLog log(path());
  EXPECT_TRUE(log.content().validity_loss);
  v1::Job job;
  log.complete(job);
  EXPECT_EQ(job.validity_loss().time_s(), 7.0);
}

TEST_F(EventLogTest, WatchersAreCalledAsLongAsTheyLive) {
  fs::create_directory(folder_.path() / "job");
  EventLogs logs(folder_.path());
  const auto log = logs.open("job");
  EXPECT_EQ(logs.open("job"), log);

  auto watcher = std::make_shared<CountingWatcher>();
  logs.watch("job", watcher);
  const auto wait_for_calls = [&](int calls) {
    eventually([&] { return watcher->calls >= calls; });
    return watcher->calls.load();
  };
  EXPECT_EQ(wait_for_calls(1), 1);

  append_steps(*log, 1, 1);
  EXPECT_EQ(wait_for_calls(2), 2);

  const std::weak_ptr<CountingWatcher> gone = watcher;
  watcher.reset();
  append_steps(*log, 2, 3);
  EXPECT_TRUE(eventually([&] { return gone.expired(); }));
}

/// Counts what it gives out and takes back.
template <class Type>
struct CountingAllocator {
  using value_type = Type;
  int* pieces;
  explicit CountingAllocator(int& count) : pieces(&count) {}
  template <class Other>
  explicit CountingAllocator(const CountingAllocator<Other>& other) : pieces(other.pieces) {}
  Type* allocate(std::size_t count) {
    ++*pieces;
    return std::allocator<Type>().allocate(count);
  }
  void deallocate(Type* memory, std::size_t count) {
    --*pieces;
    std::allocator<Type>().deallocate(memory, count);
  }
};

/// A watcher and its weak pointers share one piece of memory, which lives as long as the last of
/// them: the daemon grew by a kilobyte for each watch of a job that had ended.
TEST_F(EventLogTest, NothingIsKeptOfAWatcherThatHasGone) {
  EventLogs logs(folder_.path());
  int pieces = 0;
  auto watcher = std::allocate_shared<CountingWatcher>(CountingAllocator<CountingWatcher>(pieces));
  logs.watch("ended", watcher);
  EXPECT_TRUE(eventually([&] { return watcher->calls >= 1; }));
  EXPECT_TRUE(eventually([&] { return watcher.use_count() == 1; })) << "the notifier has it, too";
  ASSERT_EQ(pieces, 1);

  watcher.reset();
  const auto other = std::make_shared<CountingWatcher>();
  logs.watch("other", other);
  EXPECT_EQ(pieces, 0);
}

/// Its number was given to the next event, which was lost as out of order: the end of a worker that
/// ran out of memory had no cause.
/// Appends an event while only so many allocations succeed. @return whether there was memory enough
bool append_with_allocations(EventLog& log, std::int64_t step, int allocations) {
  auto event = step_event(step);
  allocations_left = allocations;
  try {
    log.append(event);
    allocations_left.reset();
    return true;
  } catch (const std::bad_alloc&) {
    allocations_left.reset();
    return false;
  }
}

TEST_F(EventLogTest, AnEventThatCouldNotBeTakenKeepsItsNumber) {
  int written_and_not_taken = 0;
  for (int allocations = 0;; ++allocations) {
    fs::remove(path());
    EventLog log(path());
    append_steps(log, 1, 3);
    const bool enough = append_with_allocations(log, 4, allocations);
    append_steps(log, 5, 5);

    std::vector<std::int64_t> steps;
    for (const v1::JobEvent& event : all_events(EventLog(path()))) {
      steps.push_back(event.step().step());
      EXPECT_EQ(event.sequence(), std::ssize(steps)) << allocations << " allocations";
    }
    const bool written = steps.size() == 5u;
    EXPECT_EQ(steps, written ? std::vector<std::int64_t>({1, 2, 3, 4, 5})
                             : std::vector<std::int64_t>({1, 2, 3, 5}));
    if (written && !enough) ++written_and_not_taken;
    if (enough) break;
  }
  EXPECT_GT(written_and_not_taken, 0);
}

}  // namespace
}  // namespace dccast::jobs
