#include "core/base/team.hpp"

#include <pthread.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <system_error>

namespace dccast {

namespace {

/// Team that together() and for_each_part() use on this thread; null without one.
thread_local Team* lent = nullptr;

/// Number of polls before a thread sleeps; they take 30 to 100 us. That is longer than the time
/// between two loops of a step, and shorter than a few times putting a thread to sleep.
constexpr int most_polls = 2000;

/// Flag in joined_: no other member may join.
constexpr int closed = 1 << 16;

/// Largest number of calls done alone before the team is tried again. At this number, waiting for
/// the team costs a few per cent of the time.
constexpr int most_solo_calls = 1023;

/// A sleep this long means that a member has lost its processor to other work [s]: a part of a time
/// slice of the system.
constexpr double long_sleep = 1e-3;

/// Longest sleep of this thread in await() since it was last set to zero [s].
thread_local double longest_sleep = 0.0;

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Polls until the value is `done`, or until the maximum number of polls is reached.
/// @return the last value read
template <class Done>
int poll(const std::atomic<int>& value, const Done& done) {
  int seen = value;
  for (int polls = 0; polls < most_polls && !done(seen); ++polls) {
    pause_briefly();
    seen = value.load(std::memory_order_acquire);
  }
  return seen;
}

/// Waits until the value is `done`: polls first, then sleeps. @return the value
template <class Done>
int await(const std::atomic<int>& value, const Done& done) {
  int seen = poll(value, done);
  if (done(seen)) return seen;

  const auto begin = std::chrono::steady_clock::now();
  while (!done(seen)) {
    value.wait(seen);
    seen = value;
  }

  const std::chrono::duration<double> slept = std::chrono::steady_clock::now() - begin;
  longest_sleep = std::max(longest_sleep, slept.count());
  return seen;
}

/// Processor time used by a thread so far [s]; 0 if the system cannot report it.
double processor_time(const std::thread& thread) {
  clockid_t clock{};
  timespec taken{};
  // native_handle() is not const, although it changes nothing.
  auto& mutable_thread = const_cast<std::thread&>(thread);
  if (pthread_getcpuclockid(mutable_thread.native_handle(), &clock) != 0) return 0.0;

  clock_gettime(clock, &taken);
  return static_cast<double>(taken.tv_sec) + 1e-9 * static_cast<double>(taken.tv_nsec);
}

}  // namespace

Team::Team(int members) : joined_(closed) {
  thrown_.resize(std::size_t(std::max(members, 1)));
  try {
    for (int member = 1; member < members; ++member) thread_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    // The results do not depend on the number of members: fewer are only slower.
  }
}

Team::~Team() {
  ending_ = true;
  ++calls_;
  calls_.notify_all();
  for (std::thread& thread : thread_) thread.join();
}

double Team::processor_seconds() const {
  double sum = 0.0;
  for (const std::thread& thread : thread_) sum += processor_time(thread);
  return sum;
}

Team::Lent::Lent(Team* team) : before_(lent) {
  lent = team;
}

Team::Lent::~Lent() {
  lent = before_;
}

Team* Team::current() {
  return lent;
}

int team_members() {
  return lent == nullptr ? 1 : lent->members();
}

void Team::run_as(int member, int members) {
  try {
    task_.call(task_.work, member, members);
  } catch (...) {
    thrown_[std::size_t(member)] = std::current_exception();
  }
}

/// The loop of every member except the caller: takes part in each call of run().
void Team::serve() {
  for (int seen = 0;;) {
    seen = await(calls_, [&](int calls) { return calls != seen; });
    if (ending_) return;

    const int member = join();
    if (member == 0) continue;

    // If all start together, their number is known only when no one else may join.
    int participants = members();
    if (task_.start == Start::together) {
      const int joined = await(joined_, [](int value) { return value >= closed; }) - closed;
      participants = joined + 1;
    }
    run_as(member, participants);

    ++leaving_;
    leaving_.notify_one();
  }
}

/// Joins the present call. @return the number of the member; 0 if it is too late to join
int Team::join() {
  int joined = joined_;
  while (joined + 1 < members()) {
    if (joined_.compare_exchange_weak(joined, joined + 1)) return joined + 1;
  }
  return 0;
}

/// Wakes the other members. @return number of participants; if all start together, it counts only
/// those that joined within the polling time
int Team::begin(const Task& task) {
  task_ = task;
  leaving_ = 0;
  joined_ = 0;
  ++calls_;
  calls_.notify_all();
  if (task.start == Start::when_ready) return members();

  poll(joined_, [this](int joined) { return joined + 1 == members(); });
  const int joined = joined_.fetch_or(closed);
  joined_.notify_all();
  return joined + 1;
}

void Team::run(const Task& task) {
  if (solo_calls_ > 0) {
    --solo_calls_;
    return run_alone(task);
  }

  longest_sleep = 0.0;
  const int participants = begin(task);
  {
    const Lent none(nullptr);  // nested loops are executed by the calling member alone
    run_as(0, participants);
  }

  // From here on no member may join; those that did have to finish.
  const int joined = joined_.fetch_or(closed) & ~closed;
  await(leaving_, [joined](int left) { return left == joined; });

  back_off_if(longest_sleep > long_sleep || participants < members());
  throw_first();
}

void Team::run_alone(const Task& task) {
  const Lent none(nullptr);
  task.call(task.work, 0, 1);
}

/// After each call that was kept waiting, the caller works alone about twice as often.
void Team::back_off_if(bool was_kept_waiting) {
  next_solo_calls_ = was_kept_waiting ? std::min(2 * next_solo_calls_ + 1, most_solo_calls) : 0;
  solo_calls_ = next_solo_calls_;
}

void Team::throw_first() {
  const auto first =
      std::ranges::find_if(thrown_, [](const auto& exception) { return exception != nullptr; });
  if (first == thrown_.end()) return;

  const std::exception_ptr thrown = *first;
  std::ranges::fill(thrown_, nullptr);
  std::rethrow_exception(thrown);
}

void Progress::reach(int place) {
  reached_ = place;
  reached_.notify_all();
}

int Progress::wait_for(int place) const {
  return await(reached_, [place](int reached) { return reached >= place; });
}

}  // namespace dccast
