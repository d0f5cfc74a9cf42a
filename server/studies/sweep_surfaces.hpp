#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "server/studies/run_results.hpp"

namespace dccast::studies {

/// A value is outside the swept range. The text names key, value and permitted range.
struct OutsideDomain : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A value cannot be read, or its key was not swept.
struct FaultyPlace : std::runtime_error {
  using std::runtime_error::runtime_error;
};

struct SweepSurface;
struct SweptKeys;

/// Response surfaces of sweeps, built on request or in advance, and kept until further runs end.
/// Safe to use from several threads.
class SweepSurfaces {
public:
  /// Both outlive this object.
  SweepSurfaces(StudiesState& state, RunResults& results) : state_(state), results_(results) {}

  /// Starts to build surfaces in advance: those of the newest studies, then those that change.
  void start();
  /// Ends building in advance.
  void stop() { state_.surface_keeper.stop(); }

  /// @return empty if there is no such study
  /// @throws OutsideDomain, FaultyPlace, CannotPredict
  std::optional<v1::Prediction> predict(const v1::PredictStudyRequest& request);
  /// Distribution of a monitor's curl over the axes of a Latin hypercube. @throws CannotPredict
  v1::Spread spread(const StudyRecord& study, const std::string& monitor);
  /// Builds surfaces in advance: whenever the number of runs has doubled, and when all have ended.
  void prepare(const std::string& id);
  /// Forgets the surfaces of a study that was removed.
  void forget(const std::string& study);

private:
  using Clock = std::chrono::steady_clock;
  using Surface = std::shared_ptr<const SweepSurface>;
  /// A sweep as it stands now.
  struct Sweep {
    StudyRecord study;
    int succeeded = 0;                                ///< number of succeeded runs
    bool running = false;                             ///< whether further runs may end
    std::optional<std::vector<EvaluatedRun>> runs{};  ///< with histories, once they were read
  };
  /// A surface, with what decides when it is built again and when it is dropped.
  struct CachedSurface {
    Surface surface;
    int succeeded = 0;
    Clock::time_point built{};
    Clock::duration took{};
    Clock::time_point used{};
  };
  struct OfStudy {
    std::shared_ptr<const SweptKeys> keys;
    std::map<std::string, CachedSurface> kept;  ///< by kind
    int prepared = 0;                           ///< succeeded runs when surfaces were last prepared
  };
  /// The surface of the present runs: kept, or built now.
  Surface surface_of(Sweep& sweep, const std::string& kind);
  /// @param of_fewer_runs  accepts an outdated surface, too
  /// @return null if there is none
  Surface kept_surface(const Sweep& sweep, const std::string& kind, bool of_fewer_runs = false);
  /// Drops the surfaces used longest ago until the rest fit, but never the last one.
  void make_room();
  /// The keys that a sweep changes, with their ends.
  std::shared_ptr<const SweptKeys> keys_of(const StudyRecord& study);

  Sweep sweep_of(const StudyRecord& study);
  /// Reads the runs at the first call.
  const std::vector<EvaluatedRun>& runs_of(Sweep& sweep);

  StudiesState& state_;
  RunResults& results_;
  std::mutex building_;  ///< serialises building; locked before mutex_
  std::mutex mutex_;     ///< guards studies_
  std::map<std::string, OfStudy> studies_;
};

}  // namespace dccast::studies
