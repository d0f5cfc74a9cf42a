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

/// There is nothing to predict from: not a sweep, or too few runs. The text has the remedy.
struct CannotPredict : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A value outside of what was swept. The text names key, value and what is permitted.
struct OutsideDomain : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A value that cannot be read, or a key that was not swept.
struct FaultyPlace : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A sweep as it stands.
struct SweepState {
  const StudyRecord& study;
  int succeeded;                                           ///< runs that have
  bool running;                                            ///< whether more may come
  std::function<const std::vector<EvaluatedRun>&()> runs;  ///< reads them with their histories
};

struct SweepSurface;
struct SweptKeys;

/// Response surfaces of sweeps, built when one is asked for or beforehand, and kept until runs
/// arrive. Safe to use from several threads.
class Predictions {
public:
  /// @throws CannotPredict, OutsideDomain, FaultyPlace
  v1::Prediction predict(const SweepState& sweep, const v1::PredictStudyRequest& request);
  /// What the axes of a Latin hypercube leave open of the curl of a monitor. @throws CannotPredict
  v1::Spread spread(const SweepState& sweep, const std::string& monitor);
  /// Builds what will be asked for: as the runs of a sweep double, and when all have ended.
  void prepare(const SweepState& sweep);
  void forget(const std::string& study);

private:
  using Clock = std::chrono::steady_clock;
  using Surface = std::shared_ptr<const SweepSurface>;
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
    int prepared = 0;                  ///< runs that had succeeded then
  };
  Surface surface_of(const SweepState& sweep, const std::string& kind);
  Surface kept_surface(const SweepState& sweep, const std::string& kind,
                       bool of_fewer_runs = false);
  void make_room();
  std::shared_ptr<const SweptKeys> keys_of(const StudyRecord& study);

  std::mutex building_;  ///< one surface is built at a time; taken before the other one
  std::mutex mutex_;     ///< of studies_
  std::map<std::string, OfStudy> studies_;
};

/// Has response surfaces built before they are asked for, on a thread of its own that stands back
/// behind everything else of the daemon.
class SurfaceKeeper {
public:
  /// Builds what the runs of a study allow.
  using Ready = std::function<void(const std::string& study)>;
  explicit SurfaceKeeper(Ready ready);

  /// The study has changed. Does not wait; several calls may lead to one look.
  void look_at(const std::string& study);
  /// Ends once what is being built is built.
  void stop();

private:
  void run(const std::stop_token& stop);
  void build(const std::string& study) const;

  const Ready ready_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::set<std::string> to_look_at_;
  std::jthread thread_;
};

}  // namespace dccast::studies
