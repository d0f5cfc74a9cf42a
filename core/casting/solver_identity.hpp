#pragma once

#include <string>

namespace dccast::casting {

/// What computes a run: program version, compiler, instruction set of the factorisation, layout of a
/// checkpoint and a digest of the sources of core/. Two programs of one identity go on from a state to
/// the same results, bit for bit; a checkpoint of any other is not taken.
const std::string& solver_identity();

}  // namespace dccast::casting
