#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/case/case.hpp"
#include "core/findings/run_failure.hpp"
#include "core/restart/sections.hpp"
#include "core/results/finding.hpp"
#include "core/results/frame.hpp"
#include "core/results/step_report.hpp"
#include "core/results/validity_loss.hpp"

namespace dccast::casting {

/// One casting, step by step, in two or three dimensions. Does not read or write result files.
class CastingRun {
public:
  virtual ~CastingRun() = default;

  virtual bool finished() const = 0;
  /// Advances by one accepted step, reducing the time step as often as necessary.
  /// @throws SolveFailed  not converged at the smallest time step
  virtual results::StepReport advance() = 0;
  virtual double time() const = 0;  ///< [s] end of the last accepted step

  /// Whether the fields at the present time are to be stored.
  virtual bool frame_is_due() const = 0;
  /// The fields at the present time; advances the time of the next frame.
  virtual results::Frame take_frame() = 0;

  /// Records a failure of the last step. Failures are part of the state, so a resumed run keeps
  /// them.
  virtual void fail(RunFailure failure) = 0;
  virtual const RunFailures& failures() const = 0;
  /// The time from which the model is no longer valid; empty while it is valid.
  virtual const std::optional<results::ValidityLoss>& validity_lost() const = 0;

  /// Findings of the run so far: each code once, in the order in which they were raised.
  virtual const std::vector<results::Finding>& findings() const = 0;

  /// The complete state of the run, as stored in a checkpoint.
  virtual restart::Sections state_sections() const = 0;
  /// Continues from a stored state of the same case. @pre no step has been made yet
  /// @return  why the state does not belong to this run: a section is missing, an array does not
  ///          fit the mesh, or a time lies outside the case; the run is then unchanged. Empty on
  ///          success.
  [[nodiscard]] virtual std::string restore(const restart::Sections& state) = 0;
};

/// Creates the run of a case in the dimension of its section.
/// @param threads  number of threads for a quarter slab; other sections use one
/// @throws InvalidCase  a file of the case cannot be read
std::unique_ptr<CastingRun> make_run(const Case& casting_case, int threads = 1);

}  // namespace dccast::casting
