#pragma once

#include <string>

#include "client/session/mould_design.hpp"

namespace dccast::client::render {

/// State, break points, half-openings and deviation from flatness of each run.
std::string mould_runs_table(const MouldDesign& design);

/// The opening that was found: break points and half-openings. Empty if there is none yet.
std::string mould_opening_table(const MouldDesign& design);

/// The resulting cold slab along the wide face.
std::string mould_profile_table(const MouldDesign& design);

/// Summary in plain words, with caveats.
std::string mould_sentence(const MouldDesign& design);

/// All of this as terminal output.
std::string mould_text(const MouldDesign& design);

}  // namespace dccast::client::render
