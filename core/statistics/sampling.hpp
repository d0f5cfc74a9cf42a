#pragma once

#include <cstdint>
#include <vector>

namespace dccast::statistics {

/// Every combination of indices below `sizes`, the last axis fastest. (run, axis)
std::vector<std::vector<int>> grid(const std::vector<int>& sizes);

/// Places of a Latin hypercube: each axis is divided into `runs` equal parts, each of which holds
/// one place (McKay, Beckman, Conover 1979). Of some such arrangements the one whose closest places
/// are farthest apart. The same on every machine.
/// @return (run, axis), each in (0, 1)
std::vector<std::vector<double>> latin_hypercube(int runs, int axes, std::uint64_t seed);

}  // namespace dccast::statistics
