#pragma once

namespace dccast {

/// Instruction sets for which lanes and band kernels are compiled, slowest first.
enum class Instructions { plain, avx2, avx512 };

/// The widest set that this processor has.
Instructions processor_instructions();

/// The set that the program works with, chosen at its first use: the processor's, or a lower one
/// that the environment asks for. DCCAST_INSTRUCTIONS is there for tests, so that one machine
/// runs what others would: plain, avx2 or avx512. It never goes beyond the processor.
/// @throws std::invalid_argument  DCCAST_INSTRUCTIONS is something else
Instructions instructions();

/// The lower of the processor's set and the one asked for. @param asked  null or empty: none
/// @throws std::invalid_argument  no such set
Instructions instructions_for(const char* asked);

}  // namespace dccast
