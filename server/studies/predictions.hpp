#pragma once

#include <chrono>
#include <condition_variable>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "server/studies/study_file.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// No prediction is possible: not a sweep, or too few runs. The text gives the remedy.
struct CannotPredict : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A value is outside the swept range. The text names key, value and permitted range.
struct OutsideDomain : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A value cannot be read, or its key was not swept.
struct FaultyPlace : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Current state of a sweep.
struct SweepState {
  /// The study and what its runs have given so far.
  const StudyRecord& study;
  int succeeded;                                           ///< number of succeeded runs
  bool running;                                            ///< whether further runs may end
  std::function<const std::vector<EvaluatedRun>&()> runs;  ///< reads the runs with histories
};

struct SweepSurface;
struct SweptKeys;

/// Response surfaces of sweeps, built on request or in advance, and kept until further runs end.
/// Safe to use from several threads.
class Predictions {
public:
  /// @throws CannotPredict, OutsideDomain, FaultyPlace
  v1::Prediction predict(const SweepState& sweep, const v1::PredictStudyRequest& request);
  /// Distribution of a monitor's curl over the axes of a Latin hypercube. @throws CannotPredict
  v1::Spread spread(const SweepState& sweep, const std::string& monitor);
  /// Builds surfaces in advance: whenever the number of runs has doubled, and when all have ended.
  void prepare(const SweepState& sweep);
  /// Forgets the surfaces of a study that was removed.
  void forget(const std::string& study);

private:
  using Clock = std::chrono::steady_clock;
  using Surface = std::shared_ptr<const SweepSurface>;
  /// A surface, with what decides when it is built again and when it is dropped.
  struct Kept {
    Surface surface;
    int succeeded = 0;
    Clock::time_point built{};
    Clock::duration took{};
    Clock::time_point used{};
  };
  struct OfStudy {
    std::shared_ptr<const SweptKeys> keys;
    std::map<std::string, Kept> kept;  ///< by kind
    int prepared = 0;                  ///< succeeded runs when surfaces were last prepared
  };
  /// The surface of the present runs: kept, or built now.
  Surface surface_of(const SweepState& sweep, const std::string& kind);
  /// @param of_fewer_runs  accepts an outdated surface, too
  /// @return null if there is none
  Surface kept_surface(const SweepState& sweep, const std::string& kind,
                       bool of_fewer_runs = false);
  /// Drops the surfaces used longest ago until the rest fit, but never the last one.
  void make_room();
  /// The keys that a sweep changes, with their ends.
  std::shared_ptr<const SweptKeys> keys_of(const StudyRecord& study);

  std::mutex building_;  ///< serialises building; locked before mutex_
  std::mutex mutex_;     ///< guards studies_
  std::map<std::string, OfStudy> studies_;
};

/// Builds response surfaces in advance, on a thread with a lower priority than the rest of the
/// daemon.
class SurfaceKeeper {
public:
  /// Builds the surfaces of a study that its runs permit.
  using Ready = std::function<void(const std::string& study)>;
  /// @param ready  builds the surface of a study; called from the keeper's thread
  explicit SurfaceKeeper(Ready ready);

  /// Schedules a study whose runs have changed. Does not wait; several calls may cause one build.
  void look_at(const std::string& study);
  /// Ends the thread after the surface being built.
  void stop();

private:
  /// The thread: builds the surface of each study that was noted, one after the other.
  void run(const std::stop_token& stop);
  /// Builds one surface; a failure is logged, as the next request builds it anyway.
  void build(const std::string& study) const;

  const Ready ready_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> to_look_at_;
  std::jthread thread_;
};

}  // namespace dccast::studies
