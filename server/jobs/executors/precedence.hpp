#pragma once

#include <chrono>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dccast::jobs {

/// How soon a run is wanted, the most urgent first. A quick or a draft run stops all runs that are
/// less urgent, on this machine, until it has ended.
enum class Urgency {
  quick,       ///< one query of few seconds: a thickness section
  draft,       ///< one query of up to half a minute: a 3D draft
  comparison,  ///< one of the short runs of a comparison
  long_query,  ///< a query that takes longer
  batch,       ///< a job of the queue, the run of a study
};

/// @param estimated_s     solving time [s], of the check of the case
/// @param one_of_several  the caller compares several runs
Urgency urgency_of_query(double estimated_s, bool one_of_several);

/// How far a worker lowers its own priority (nice), 0 to 19. It cannot raise it again.
int nice_of(Urgency urgency);

/// For how long a worker stays stopped at most, should no one continue it: its own timer does then.
/// Runs that are stopped for longer, behind one query after the other, therefore get some of the
/// processor at last.
inline constexpr std::chrono::seconds longest_stop{30};

/// The run that others are stopped for.
struct MoreUrgentRun {
  double left_s = 0.0;  ///< solving time that it still needs, from its estimate [s]

  /// "stopped while a more urgent query runs"
  std::string in_words() const;
};

/// Which runs of this machine stand still for more urgent ones. Safe to use from several threads.
class Precedence {
public:
  /// Called with the more urgent run when this one is to stop, and with nothing when it may go on.
  /// It comes from the thread of any run and must neither wait nor call this object.
  using OnChange = std::function<void(const std::optional<MoreUrgentRun>& stopped_for)>;

private:
  struct Entry {
    Urgency urgency;
    double estimated_s;
    OnChange on_change;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    bool stopped = false;
  };
  using Entries = std::list<Entry>;

public:
  /// The place of a run among the others, from its begin to its end. A run that ends while it is
  /// stopped is told to go on first.
  class Place {
  public:
    Place() = default;
    Place(Precedence& precedence, Entries::iterator entry)
        : precedence_(&precedence), entry_(entry) {}
    Place(Place&& other) noexcept
        : precedence_(std::exchange(other.precedence_, nullptr)), entry_(other.entry_) {}
    Place& operator=(Place&& other) noexcept {
      std::swap(precedence_, other.precedence_);
      std::swap(entry_, other.entry_);
      return *this;
    }
    ~Place() { leave(); }
    void leave();

  private:
    Precedence* precedence_ = nullptr;
    Entries::iterator entry_{};
  };

  /// @param estimated_s  solving time [s]
  /// @param on_change    may be called before this returns
  [[nodiscard]] Place enter(Urgency urgency, double estimated_s, OnChange on_change);

private:
  void remove(Entries::iterator entry);
  void stop_or_continue_all();

  std::mutex mutex_;
  Entries entries_;
};

}  // namespace dccast::jobs
