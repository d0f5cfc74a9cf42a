#include "core/base/team.hpp"

#include <pthread.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <system_error>

namespace dccast {

namespace {

thread_local Team* lent = nullptr;

/// Number of polls before a thread sleeps, 30 to 100 us: longer than the time between two loops of
/// a step, shorter than putting a thread to sleep and waking it a few times.
constexpr int looks = 2000;
/// Value of door_: no other member may join.
constexpr int closed = 1 << 16;
/// Largest number of calls done alone before the team is tried again: its waits then cost a few per
/// cent.
constexpr int longest_rest = 1023;

/// A sleep this long means that a member has lost its processor to other work [s]: part of a time
/// slice.
constexpr double long_sleep = 1e-3;

thread_local double longest_sleep = 0.0;  // [s] since it was last set to zero

void pause_briefly() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#endif
}

/// Polls until the value is `done`, or until the maximum number of polls.
template <class Done>
int look_at(const std::atomic<int>& value, const Done& done) {
  int seen = value;
  for (int look = 0; look < looks && !done(seen); ++look) {
    pause_briefly();
    seen = value.load(std::memory_order_acquire);
  }
  return seen;
}

/// Waits until the value is `done`.
template <class Done>
int await(const std::atomic<int>& value, const Done& done) {
  int seen = look_at(value, done);
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

double seconds_of(const std::thread& thread) {
  clockid_t clock{};
  timespec taken{};
  auto& of_library = const_cast<std::thread&>(thread);
  if (pthread_getcpuclockid(of_library.native_handle(), &clock) != 0) return 0.0;
  clock_gettime(clock, &taken);
  return static_cast<double>(taken.tv_sec) + 1e-9 * static_cast<double>(taken.tv_nsec);
}

}  // namespace

Team::Team(int members) : door_(closed) {
  thrown_.resize(std::size_t(std::max(members, 1)));
  try {
    for (int member = 1; member < members; ++member) thread_.emplace_back([this] { serve(); });
  } catch (const std::system_error&) {
    // Fewer members compute the same numbers, only more slowly.
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
  for (const std::thread& thread : thread_) sum += seconds_of(thread);
  return sum;
}

Team::Lent::Lent(Team* team) : before_(lent) {
  lent = team;
}

Team::Lent::~Lent() {
  lent = before_;
}

Team* Team::of_this_thread() {
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

void Team::serve() {
  for (int seen = 0;;) {
    seen = await(calls_, [&](int calls) { return calls != seen; });
    if (ending_) return;
    const int member = enter();
    if (member == 0) continue;
    int all = members();
    if (task_.at_once) all = (await(door_, [](int door) { return door >= closed; }) - closed) + 1;
    run_as(member, all);
    ++leaving_;
    leaving_.notify_one();
  }
}

/// @return the number of the member; 0 if it is too late to join
int Team::enter() {
  int inside = door_;
  while (inside + 1 < members()) {
    if (door_.compare_exchange_weak(inside, inside + 1)) return inside + 1;
  }
  return 0;
}

/// Wakes the others. @return number of members; if all start together, of those that are available
int Team::begin(const Task& task) {
  task_ = task;
  leaving_ = 0;
  door_ = 0;
  ++calls_;
  calls_.notify_all();
  if (!task.at_once) return members();
  look_at(door_, [this](int inside) { return inside + 1 == members(); });
  const int inside = door_.fetch_or(closed);
  door_.notify_all();
  return inside + 1;
}

void Team::run(const Task& task) {
  if (rest_ > 0) {
    --rest_;
    return run_alone(task);
  }
  longest_sleep = 0.0;
  const int all = begin(task);
  {
    const Lent none(nullptr);  // nested loops are executed by the calling member alone
    run_as(0, all);
  }
  const int inside = door_.fetch_or(closed) & ~closed;
  await(leaving_, [inside](int left) { return left == inside; });
  rest_if(longest_sleep > long_sleep || all < members());
  throw_first();
}

void Team::run_alone(const Task& task) {
  const Lent none(nullptr);
  task.call(task.work, 0, 1);
}

void Team::rest_if(bool was_kept_waiting) {
  next_rest_ = was_kept_waiting ? std::min(2 * next_rest_ + 1, longest_rest) : 0;
  rest_ = next_rest_;
}

void Team::throw_first() {
  const auto first = std::ranges::find_if(thrown_, [](const auto& it) { return it != nullptr; });
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
