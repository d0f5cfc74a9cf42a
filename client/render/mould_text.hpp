#pragma once

#include <string>

#include "client/mould_design.hpp"

namespace dccast::client::render {

/// Of each run its state, break points, half-openings and how far its slab is from flat.
std::string mould_runs_table(const MouldDesign& design);

/// The opening that was found: break points and half-openings. Empty while there is none.
std::string mould_opening_table(const MouldDesign& design);

/// The cold slab that it gives, along the wide face.
std::string mould_profile_table(const MouldDesign& design);

/// What came of it in plain words, and what to mind.
std::string mould_sentence(const MouldDesign& design);

/// All of this, as the terminal shows it.
std::string mould_text(const MouldDesign& design);

}  // namespace dccast::client::render
