#pragma once

#include "core/findings/step_figures.hpp"

namespace dccast::casting {

/// Gap between shell and bottom block into which melt can run [m]. The surface tension of
/// aluminium, 0.9 N/m, bridges gaps up to 2 gamma / (rho g h), which is 0.39 mm under 0.2 m of
/// melt.
inline constexpr double open_gap = 0.3e-3;

/// Whether the shell over the bottom block is thinner than the case permits; only once the block
/// moves.
inline bool bottom_shell_is_thin(const Case& c, const StepFigures& f) {
  return f.moves && f.mechanical && f.bottom_shell.value < c.plausibility.minimum_shell;
}

}  // namespace dccast::casting
