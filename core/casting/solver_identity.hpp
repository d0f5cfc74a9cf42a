#pragma once

#include <string>

namespace dccast::casting {

/// Identifies the solver: program version, compiler, instruction set of the factorisation,
/// checkpoint format and a digest of the sources of core/. Programs with the same identity continue
/// from a state to bit-identical results; a checkpoint with another identity is not accepted.
const std::string& solver_identity();

}  // namespace dccast::casting
