#pragma once

namespace dccast {

/// Instruction sets for which lanes and band kernels are compiled, slowest first.
enum class Instructions { plain, avx2, avx512 };

/// The widest instruction set that this processor supports.
Instructions processor_instructions();

/// The instruction set that the program uses, chosen at the first call: that of the processor, or a
/// lower one requested by the environment variable DCCAST_INSTRUCTIONS (plain, avx2 or avx512). The
/// variable exists for tests, so that one machine can run the code of others. It never selects a
/// set that the processor does not support.
/// @throws std::invalid_argument  DCCAST_INSTRUCTIONS is something else
Instructions instructions();

/// The lower of the processor's set and the requested one. @param asked  null or empty: no request
/// @throws std::invalid_argument  no such set
Instructions instructions_for(const char* asked);

}  // namespace dccast
