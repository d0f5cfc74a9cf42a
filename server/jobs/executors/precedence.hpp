#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <list>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace dccast::jobs {

/// Urgency of a run, the most urgent first. A quick or a draft run stops all less urgent runs on
/// this machine while it computes, within the bounds of Precedence.
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

/// How often it is seen whether an urgent run computes.
inline constexpr std::chrono::milliseconds between_looks{100};

/// Decides which runs of this machine are stopped for more urgent ones. Safe to use from several
/// threads.
///
/// A run that waits, for readings of a casting for example, stops no other: it computes if it has
/// used a tenth of a processor since the last look. What a run may take from others has a bound:
/// its precedence ends for good after 30 s, or after twice the processor time of its estimate.
class Precedence {
public:
  using Clock = std::chrono::steady_clock;

  static constexpr std::chrono::seconds longest_hold{30};

  /// A run that may be stopped, and may stop others.
  struct Run {
    Urgency urgency = Urgency::batch;
    double estimated_s = 0.0;  ///< solving time [s]; 0: not known
    /// Called with the more urgent run to stop this one, and with nothing to continue it. The call
    /// comes from any thread; it must neither block nor call this object.
    std::function<void(const std::optional<MoreUrgentRun>& stopped_for)> on_change{};
    /// Processor time of its process [s]; nothing: not known. Called from any thread.
    std::function<std::optional<double>()> processor_s{};
  };

  Precedence();

private:
  /// A run, with what is known of its use of the processors.
  struct Entry {
    Run run;
    std::optional<double> begin_s;  ///< its processor time when it was entered [s]
    std::optional<double> last_s;   ///< and at the last look
    Clock::time_point looked = Clock::now();
    Clock::duration held{};  ///< for which it has stopped others
    bool computes = true;    ///< at the last look
    bool precedence_has_ended = false;
    bool stopped = false;

    /// Processor time since it was entered [s].
    double used_s() const { return last_s.value_or(0.0) - begin_s.value_or(0.0); }
    /// Whether less urgent runs are stopped for it.
    bool stops_others() const;
    /// Sees how much it has computed since the last look.
    void look(Clock::time_point now);
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

  /// @param run  its `on_change` may be called before this returns
  [[nodiscard]] Registration enter(Run run);

private:
  /// Takes out an entry and continues what it had stopped.
  void remove(Entries::iterator entry);
  /// Decides anew which runs are stopped.
  void stop_or_continue_all();
  /// The thread: looks at the runs while one may stop others.
  void watch(const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  Entries entries_;
  std::jthread watcher_;  ///< last: it uses the others
};

}  // namespace dccast::jobs
