#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <thread>
#include <vector>

namespace dccast {

/// A pool of threads, including the calling one, that work on one loop at a time. The threads are
/// kept between loops: an idle member spins for some microseconds, then sleeps.
///
/// Results do not depend on which member does which work. Work is divided by the problem, not by
/// the number of members, and sums are formed in an order that does not depend on it either: one
/// member and many give the same bits.
///
/// A member whose processor is busy with other work is therefore not waited for: the others do its
/// share. If the team is kept waiting all the same, the caller works alone for some calls, for more
/// of them the more often this happens.
class Team {
public:
  /// @param members  number of threads including the caller, at least 1; fewer are used if the
  ///                 system cannot create as many
  explicit Team(int members = 1);
  /// Ends the threads.
  ~Team();
  Team(const Team&) = delete;
  Team& operator=(const Team&) = delete;

  /// Number of threads, the calling one included [1].
  int members() const { return static_cast<int>(thread_.size()) + 1; }
  /// Processor time used so far by the members other than the caller [s].
  double processor_seconds() const;

  /// Lends a team to the calling thread until the object goes out of scope: together() and
  /// for_each_part() use it. Without a team, with null, or inside their work, a thread works alone.
  class Lent {
  public:
    /// @param team  must outlive this object; null: work alone
    explicit Lent(Team* team);
    /// Gives the team back that was lent before.
    ~Lent();
    Lent(const Lent&) = delete;
    Lent& operator=(const Lent&) = delete;

  private:
    Team* before_;  ///< lent until now; the destructor restores it
  };

private:
  template <class Work>
  friend void together(const Work& work);
  template <class Work>
  friend void for_each_part(std::size_t parts, const Work& work);
  friend int team_members();

  /// When the members begin with a task.
  enum class Start {
    together,    ///< when all available members have joined: they may wait for each other
    when_ready,  ///< each as soon as it has joined; `members` is then the size of the whole team
  };

  /// A callable of any type, by its address.
  struct Task {
    /// Function that does a member's share of the work; types are erased, so that no memory is
    /// needed.
    void (*call)(const void* work, int member, int members);
    const void* work;
    Start start;
  };
  /// Refers to `work`, which must live until run() returns.
  template <class Work>
  static Task make_task(const Work& work, Start start) {
    const auto call = [](const void* erased, int member, int members) {
      (*static_cast<const Work*>(erased))(member, members);
    };
    return {call, &work, start};
  }

  /// Team lent to the calling thread; null without one.
  static Team* current();
  /// Does the work with all members that are there, and returns when all are done.
  void run(const Task& task);
  /// Does the work of all members in the calling thread.
  void run_alone(const Task& task);
  /// Wakes the other members. @return number of participants; if all start together, of those that
  /// joined within the polling time
  int begin(const Task& task);
  /// Does one member's share and keeps the first exception.
  void run_as(int member, int members);
  /// The loop of a member: spins for a while, then sleeps until there is work.
  void serve();
  /// Joins the present call. @return the number of the member; 0 if it is too late
  int join();
  /// Works alone for the next 1, 3, 7, ... calls if a member made the caller wait.
  void back_off_if(bool was_kept_waiting);
  /// Rethrows the exception of the lowest member, so that it does not depend on chance.
  void throw_first();

  std::vector<std::thread> thread_;         ///< the members except the caller
  std::vector<std::exception_ptr> thrown_;  ///< (member) exception of the present call, or null
  Task task_{};                             ///< of the present call of run()
  std::atomic<int> calls_{0};    ///< number of calls of run(); an increment wakes the members
  std::atomic<int> joined_{0};   ///< members besides the caller that take part, and a flag: closed
  std::atomic<int> leaving_{0};  ///< number of those that have finished
  std::atomic<bool> ending_{false};  ///< the members return from serve()
  int solo_calls_ = 0;               ///< number of following calls that the caller does alone
  int next_solo_calls_ = 0;          ///< that number after the next call that is kept waiting
};

/// Number of members of the team lent to this thread; 1 without a team.
int team_members();

/// Calls work(member, members) concurrently for members 0 to members - 1, the available members of
/// the team lent to this thread, and waits for all. The exception of the first member that threw is
/// rethrown. Work whose members wait for each other must not throw, as the others would wait
/// without end.
template <class Work>
void together(const Work& work) {
  Team* team = Team::current();
  if (team == nullptr || team->members() == 1) return work(0, 1);
  team->run(Team::make_task(work, Team::Start::together));
}

/// Calls work(part) once for every part from 0 to `parts` - 1, in any order and several at a time.
/// After an exception no further parts are started, and it is rethrown.
template <class Work>
void for_each_part(std::size_t parts, const Work& work) {
  if (parts <= 1 || team_members() == 1) {
    for (std::size_t part = 0; part < parts; ++part) work(part);
    return;
  }

  // Each participant takes the next part that no one has taken.
  std::atomic<std::size_t> next{0};
  const auto take_parts = [&](int, int) {
    try {
      for (std::size_t part = next++; part < parts; part = next++) work(part);
    } catch (...) {
      next = parts;
      throw;
    }
  };

  Team::current()->run(Team::make_task(take_parts, Team::Start::when_ready));
}

/// Calls work(first, end) for ranges that together cover 0 to `count` - 1, several at a time.
/// @param shortest  shortest range worth a call
template <class Work>
void for_each_stretch(std::size_t count, std::size_t shortest, const Work& work) {
  constexpr std::size_t most_stretches = 8;
  const std::size_t stretches = std::clamp(count / shortest, std::size_t(1), most_stretches);
  for_each_part(stretches, [&](std::size_t stretch) {
    work(count * stretch / stretches, count * (stretch + 1) / stretches);
  });
}

/// Progress of a member that other members can wait for: a number that only grows. One member
/// calls reach(), any number of them wait.
class Progress {
public:
  /// @param reached  progress at the beginning
  explicit Progress(int reached) : reached_(reached) {}
  /// Publishes the progress and wakes those that wait for it.
  void reach(int place);
  /// @return the progress reached, at least `place`
  int wait_for(int place) const;

private:
  // On a cache line of its own: writes to neighbours would slow down those that poll it.
  alignas(64) std::atomic<int> reached_;
};

}  // namespace dccast
