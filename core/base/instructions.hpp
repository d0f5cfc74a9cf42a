#pragma once

#include <cstddef>
#include <utility>

// GCC warns that the calling convention of vector types depends on the instruction set. Lanes are
// passed by value only between functions that are compiled for the same set.
#pragma GCC diagnostic ignored "-Wpsabi"

namespace dccast {

/// Instruction sets for which lanes and band kernels are compiled, slowest first.
enum class Instructions { plain, avx2, avx512 };

/// The widest instruction set that this processor supports; plain on other than x86-64.
Instructions processor_instructions();

/// The instruction set that the program uses, chosen at the first call: that of the processor, or a
/// lower one requested by the environment variable DCCAST_INSTRUCTIONS (plain, avx2 or avx512). The
/// variable exists for tests, so that one machine can run the code of others. It never selects a
/// set that the processor does not support.
/// @throws std::invalid_argument  DCCAST_INSTRUCTIONS is something else
Instructions instructions();

/// The lower of the processor's set and the requested one.
/// @param requested  name of a set; null or empty: no request
/// @throws std::invalid_argument  no set has this name
Instructions instructions_for(const char* requested);

/// `Count` numbers side by side in one register. The operators + - * / and the comparisons act on
/// all of them at once, so that a formula written for one number evaluates several elements or
/// points.
template <int Count>
struct LanesOf {
  typedef double type __attribute__((vector_size(8 * Count), may_alias));
};
/// Register of `Count` numbers; see LanesOf.
template <int Count>
using Lanes = typename LanesOf<Count>::type;

/// How many numbers the registers of the instruction set in use hold: 8, 4 or 2.
inline int register_lanes() {
  static const int count = 2 << static_cast<int>(instructions());
  return count;
}

/// An upper bound of register_lanes().
inline constexpr int most_lanes = 8;  // of AVX-512

namespace detail {
#if defined(__x86_64__)
// gnu::flatten inlines everything that `work` calls, so that all of it is compiled for the
// instruction set of these functions.
template <class Work>
[[gnu::target("avx2,fma"), gnu::flatten]] void on_avx2(const Work& work) {
  work.template operator()<4>();
}

template <class Work>
[[gnu::target("avx2,fma,avx512f,avx512vl,avx512dq,prefer-vector-width=512"), gnu::flatten]] void
on_avx512(const Work& work) {
  work.template operator()<8>();
}
#endif
}  // namespace detail

/// Runs work.operator()<Count>() with the Count of register_lanes(), compiled for a processor with
/// such registers. Last bits may differ between processors of different registers; on one
/// processor they are always the same.
template <class Work>
void with_lanes(const Work& work) {
#if defined(__x86_64__)
  if (register_lanes() == 8) return detail::on_avx512(work);
  if (register_lanes() == 4) return detail::on_avx2(work);
#endif
  work.template operator()<2>();
}

/// Lanes with the value give(i) in lane i, each in the unit of `give`.
template <int Count, class Give>
Lanes<Count> lanes_of(const Give& give) {
  return [&]<std::size_t... Lane>(std::index_sequence<Lane...>) {
    return Lanes<Count>{give(Lane)...};
  }
  (std::make_index_sequence<Count>{});
}

/// Square root of each lane, in the root of its unit.
template <int Count>
Lanes<Count> root(const Lanes<Count>& x) {
  Lanes<Count> y;
  for (int i = 0; i < Count; ++i) y[i] = __builtin_sqrt(x[i]);
  return y;
}

#if defined(__x86_64__)
namespace detail {
// Powers of glibc's libmvec, under the names of the x86-64 vector function ABI. They are at most 4
// units in the last place off. A register is passed only between functions for its instruction set.
extern "C" {
LanesOf<2>::type _ZGVbN2vv_pow(LanesOf<2>::type base, LanesOf<2>::type exponent);
[[gnu::target("avx2")]] LanesOf<4>::type _ZGVdN4vv_pow(LanesOf<4>::type base,
                                                       LanesOf<4>::type exponent);
[[gnu::target("avx512f")]] LanesOf<8>::type _ZGVeN8vv_pow(LanesOf<8>::type base,
                                                          LanesOf<8>::type exponent);
}

inline void raise(LanesOf<2>::type& x, double exponent) {
  x = _ZGVbN2vv_pow(x, LanesOf<2>::type{} + exponent);
}
[[gnu::target("avx2")]] inline void raise(LanesOf<4>::type& x, double exponent) {
  x = _ZGVdN4vv_pow(x, LanesOf<4>::type{} + exponent);
}
[[gnu::target("avx512f")]] inline void raise(LanesOf<8>::type& x, double exponent) {
  x = _ZGVeN8vv_pow(x, LanesOf<8>::type{} + exponent);
}
}  // namespace detail
#endif

/// The power of each lane, in the power of its unit. @param base  not negative
template <int Count>
Lanes<Count> power(const Lanes<Count>& base, double exponent) {
  Lanes<Count> x = base;
#if defined(__x86_64__)
  detail::raise(x, exponent);
#else
  for (int i = 0; i < Count; ++i) x[i] = __builtin_pow(x[i], exponent);
#endif
  return x;
}

/// Whether a comparison holds in at least one lane. @param mask  result of the comparison
template <int Count, class Mask>
bool any(const Mask& mask) {
  long long found = 0;
  for (int i = 0; i < Count; ++i) found |= mask[i];
  return found != 0;
}

/// Loads lanes from consecutive numbers, in their unit. The address needs no alignment.
template <int Count>
Lanes<Count> load(const double* from) {
  Lanes<Count> lanes;
  __builtin_memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

/// Stores lanes at consecutive numbers, in their unit. The address needs no alignment.
template <int Count>
void store(const Lanes<Count>& lanes, double* to) {
  __builtin_memcpy(to, &lanes, sizeof lanes);
}

}  // namespace dccast
