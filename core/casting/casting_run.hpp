#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/casting/case.hpp"
#include "core/casting/run_failure.hpp"
#include "core/restart/sections.hpp"
#include "core/results/finding.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// One casting, step by step, in two or three dimensions. Knows nothing of files.
class CastingRun {
public:
  virtual ~CastingRun() = default;

  virtual bool finished() const = 0;
  /// Makes one accepted step, cutting the time step as often as it takes.
  /// @throws SolveFailed  at the smallest time step
  virtual results::StepReport advance() = 0;
  virtual double time() const = 0;  ///< [s] end of the last accepted step

  /// Whether the fields of this instant are to be stored.
  virtual bool frame_is_due() const = 0;
  /// The fields of this instant; moves the time of the next frame on.
  virtual results::Frame take_frame() = 0;

  /// Lists a failure of the step just made: part of the state, so that no resumption forgets it.
  virtual void fail(RunFailure failure) = 0;
  virtual const RunFailures& failures() const = 0;
  /// The moment from which the model is no longer valid; nothing while it is.
  virtual const std::optional<results::ValidityLoss>& validity_lost() const = 0;

  /// What an engineer should know of the run so far, each code once, in the order they came.
  virtual const std::vector<results::Finding>& findings() const = 0;

  /// Everything that a checkpoint of the run has to keep.
  virtual restart::Sections state_sections() const = 0;
  /// Goes on from another state of the same case. Asked of a run that has made no step.
  /// @return  why it cannot be of this run: a section that is missing, an array that does not fit
  ///          the mesh, a time outside the case; empty when it can. The run stays as it was then.
  virtual std::string restore(const restart::Sections& state) = 0;
};

/// The run of a case, in the dimension of its section.
/// @param threads  of a quarter slab; other sections take one
/// @throws InvalidCase  a file of the case cannot be read
std::unique_ptr<CastingRun> make_run(const Case& casting_case, int threads = 1);

}  // namespace dccast::casting
