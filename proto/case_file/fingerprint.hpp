#pragma once

#include <map>
#include <string>

#include "dccast/v1/case.pb.h"

namespace dccast::case_file {

/// What two cases with all their defaults must have in common to be the same. The title never
/// counts.
enum class Same {
  input,    ///< every key: what a repeated request must name
  answer,   ///< all that determines the figures of a run: not checkpoints, nor ranges of data
  casting,  ///< what is cast, with the ranges of its data: not quality, mesh, time steps, and keys
            ///< that do not affect the results
  recipe,   ///< what a plant casts: as casting, without ranges of data, limits of findings,
            ///< monitors and the end
};

/// SHA-256 of a case, equal for cases that are the same. Taken over canonical JSON, which does not
/// depend on the version of a library.
/// @param complete  with defaults and alloy card
/// @param files     SHA-256 of the files that the case names, by name
std::string fingerprint(v1::Case complete, Same same,
                        const std::map<std::string, std::string>& files = {});

/// A case whose data have no range any more.
v1::Case without_ranges(v1::Case description);

}  // namespace dccast::case_file
