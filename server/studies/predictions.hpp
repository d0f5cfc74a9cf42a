#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "dccast/v1/service.pb.h"
#include "server/studies/study_file.hpp"
#include "server/studies/study_plan.hpp"

namespace dccast::studies {

/// There is nothing to predict from: not a sweep, or too few runs. The text has the remedy.
class CannotPredict : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};
/// A value outside of what was swept. The text names key, value and what is permitted.
class OutsideDomain : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};
/// A value that cannot be read, or a key that was not swept.
class FaultyPlace : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

class SweepSurface;
struct SweptKeys;

/// Response surfaces of sweeps, built when one is asked for or beforehand, and kept until runs
/// arrive. Safe to use from several threads.
class Predictions {
public:
  Predictions();
  ~Predictions();

  /// @param succeeded  runs of the study that have
  /// @param running    whether more may come
  /// @param runs       reads them with their histories
  /// @throws CannotPredict, OutsideDomain, FaultyPlace
  v1::Prediction predict(const StudyRecord& study, int succeeded, bool running,
                         const v1::PredictStudyRequest& request,
                         const std::function<std::vector<EvaluatedRun>()>& runs);
  /// What the axes of a Latin hypercube leave open of the curl of a monitor. Parameters as above.
  /// @throws CannotPredict
  v1::Spread spread(const StudyRecord& study, int succeeded, bool running,
                    const std::string& monitor,
                    const std::function<std::vector<EvaluatedRun>()>& runs);
  /// Builds what will be asked for: as the runs of a sweep double, and when all have ended.
  void prepare(const StudyRecord& study, int succeeded, bool running,
               const std::function<std::vector<EvaluatedRun>()>& runs);
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
  /// What a surface is looked for by.
  struct Wanted {
    const StudyRecord& study;
    int succeeded;
    bool running;
    const std::string& kind;
  };
  Surface surface_of(const Wanted& wanted, const std::function<Surface()>& build);
  Surface kept_surface(const Wanted& wanted, bool of_fewer_runs = false);
  void keep(const Wanted& wanted, Surface surface, Clock::time_point begin);
  void make_room();

  std::shared_ptr<const SweptKeys> keys_of(const StudyRecord& study);

  std::mutex building_;  ///< one surface is built at a time; taken before the other one
  std::mutex mutex_;     ///< of all below
  std::map<std::string, std::shared_ptr<const SweptKeys>> keys_;  ///< by study
  std::map<std::string, std::map<std::string, Kept>> kept_;       ///< by study and kind
  std::map<std::string, int> prepared_;  ///< runs of a study that had succeeded then
};

}  // namespace dccast::studies
