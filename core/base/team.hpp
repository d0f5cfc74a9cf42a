#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace dccast {

/// Threads that work together on one loop at a time, the one that calls among them. They are kept
/// from loop to loop: a member without work spins for some microseconds, then sleeps.
///
/// Who does what never decides a result. Work is divided by what it is about, and what several
/// parts add to is added in an order that does not depend on the number of members: so one member
/// and many give the same bits.
///
/// Therefore nobody waits for a member that does not come because the system has other work for its
/// processor: the others do without it. A team that was kept waiting all the same works alone for
/// some calls, the longer the more often that happens.
class Team {
public:
  /// @param members  with the thread that calls, at least 1; fewer where the system has no more
  /// threads to give
  explicit Team(int members = 1);
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  int members() const { return static_cast<int>(thread_.size()) + 1; }
  /// What the members beside the caller have taken of processors so far [s].
  double processor_seconds() const;

  /// Lends a team to the calling thread until it goes out of scope: together() and for_each_part()
  /// use it. Without one, or with null, and inside their work, a thread is alone.
  class Lent {
  public:
    explicit Lent(Team* team);
    ~Lent();
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;

  private:
    Team* before_;
  };

private:
  template <class Work>
  friend void together(const Work& work);
  template <class Work>
  friend void for_each_part(std::size_t parts, const Work& work);
  friend int team_members();

  /// A callable of any type, by its address.
  struct Task {
    void (*call)(const void* work, int member, int members);
    const void* work;
    bool at_once;  ///< all members begin together; else each when it comes, and `members` is of all
  };
  template <class Work>
  static Task task_of(const Work& work, bool at_once) {
    const auto call = [](const void* it, int member, int members) {
      (*static_cast<const Work*>(it))(member, members);
    };
    return {call, &work, at_once};
  }

  static Team* of_this_thread();
  void run(const Task& task);
  void run_alone(const Task& task);
  int begin(const Task& task);
  void run_as(int member, int members);
  void serve();
  int enter();
  void rest_if(bool was_kept_waiting);
  void throw_first();

  std::vector<std::thread> thread_;
  std::vector<std::exception_ptr> thrown_;  ///< (member)
  Task task_{};
  std::atomic<int> calls_{0};    ///< of run(); one more wakes the members
  std::atomic<int> door_{0};     ///< members beside the caller that take part, and whether more may
  std::atomic<int> leaving_{0};  ///< of those, how many are done
  std::atomic<bool> ending_{false};
  int rest_ = 0;       ///< calls that the caller does alone from now on
  int next_rest_ = 0;  ///< and after it is kept waiting the next time
};

/// Members of the team lent to this thread; 1 without one.
int team_members();

/// Calls work(member, members) for members 0 to members - 1, at the same time, and waits for all:
/// those of the team lent to this thread that are there. The exception of the first member that
/// threw is thrown again. Work whose members wait for each other must not throw.
template <class Work>
void together(const Work& work) {
  Team* team = Team::of_this_thread();
  if (team == nullptr || team->members() == 1) return work(0, 1);
  team->run(Team::task_of(work, true));
}

/// Calls work(part) for every part from 0 on, each once, in any order and several at a time. After
/// a part that threw no more are begun.
template <class Work>
void for_each_part(std::size_t parts, const Work& work) {
  if (parts <= 1 || team_members() == 1) {
    for (std::size_t part = 0; part < parts; ++part) work(part);
    return;
  }
  std::atomic<std::size_t> next{0};
  const auto take_parts = [&](int, int) {
    try {
      for (std::size_t part = next++; part < parts; part = next++) work(part);
    } catch (...) {
      next = parts;
      throw;
    }
  };
  Team::of_this_thread()->run(Team::task_of(take_parts, false));
}

/// Calls work(first, end) for stretches of the numbers from 0 to `count` - 1, several at a time.
/// @param shortest  stretch worth a call
template <class Work>
void for_each_stretch(std::size_t count, std::size_t shortest, const Work& work) {
  constexpr std::size_t most_stretches = 8;
  const std::size_t stretches = std::clamp(count / shortest, std::size_t(1), most_stretches);
  for_each_part(stretches, [&](std::size_t stretch) {
    work(count * stretch / stretches, count * (stretch + 1) / stretches);
  });
}

/// How far the members have come, for each other to wait for: a number that only grows.
class Progress {
public:
  explicit Progress(int reached) : reached_(reached) {}
  void reach(int place);
  /// @return how far it has come, not less than `place`
  int wait_for(int place) const;

private:
  alignas(64) std::atomic<int> reached_;
};

}  // namespace dccast
