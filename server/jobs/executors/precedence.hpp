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

/// Urgency of a run, the most urgent first. A quick or a draft run stops all less urgent runs on
/// this machine until it has ended.
enum class Urgency {
  quick,       ///< one query of few seconds: a thickness section
  draft,       ///< one query of up to half a minute: a 3D draft
  comparison,  ///< one of the short runs of a comparison
  long_query,  ///< a query that takes longer
  batch,       ///< a job of the queue, the run of a study
};

/// Urgency of a query.
/// @param estimated_s     solving time [s], estimated by the check of the case
/// @param one_of_several  the caller compares several runs
Urgency classify_query(double estimated_s, bool one_of_several);

/// The nice value of a worker, 0 to 19. A worker can lower its priority, but not raise it again.
int nice_value(Urgency urgency);

/// Longest time for which a worker stays stopped; then its own timer continues it. Runs behind an
/// unbroken sequence of queries therefore still make progress.
inline constexpr std::chrono::seconds longest_stop{30};

/// The run for which others are stopped.
struct MoreUrgentRun {
  double remaining_s = 0.0;  ///< remaining solving time, from its estimate [s]

  /// "stopped while a more urgent query runs"
  std::string description() const;
};

/// Decides which runs of this machine are stopped for more urgent ones. Safe to use from several
/// threads.
class Precedence {
public:
  /// Called with the more urgent run to stop this one, and with nothing to continue it. The call
  /// comes from the thread of any run; it must neither block nor call this object.
  using OnChange = std::function<void(const std::optional<MoreUrgentRun>& stopped_for)>;

private:
  /// A run, with its urgency and the function that is called when it is stopped.
  struct Entry {
    Urgency urgency;
    double estimated_s;
    OnChange on_change;
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    bool stopped = false;
  };
  using Entries = std::list<Entry>;

public:
  /// Registration of a run, from its begin to its end. A run that ends while it is stopped is
  /// continued first.
  class Registration {
  public:
    Registration() = default;
    /// Leaves when destroyed, so that no stopped run is forgotten.
    Registration(Precedence& precedence, Entries::iterator entry)
        : precedence_(&precedence), entry_(entry) {}
    Registration(Registration&& other) noexcept
        : precedence_(std::exchange(other.precedence_, nullptr)), entry_(other.entry_) {}
    Registration& operator=(Registration&& other) noexcept {
      std::swap(precedence_, other.precedence_);
      std::swap(entry_, other.entry_);
      return *this;
    }
    ~Registration() { leave(); }
    /// Ends the registration; less urgent runs may continue.
    void leave();

  private:
    Precedence* precedence_ = nullptr;
    Entries::iterator entry_{};
  };

  /// @param estimated_s  solving time [s]
  /// @param on_change    may be called before this returns
  [[nodiscard]] Registration enter(Urgency urgency, double estimated_s, OnChange on_change);

private:
  /// Takes out an entry and continues what it had stopped.
  void remove(Entries::iterator entry);
  /// Decides anew which runs are stopped.
  void stop_or_continue_all();

  std::mutex mutex_;
  Entries entries_;
};

}  // namespace dccast::jobs
