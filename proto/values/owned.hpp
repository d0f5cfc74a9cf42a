#pragma once

#include <memory>

namespace dccast::values {

/// Frees an object of a C library with the library's own function.
template <auto Free>
struct Freed {
  /// Frees a thing by the library's function.
  template <typename Thing>
  void operator()(Thing* thing) const {
    Free(thing);
  }
};

/// An object of a C library, freed with its owner: Owned<BIO, BIO_free>.
template <typename Thing, auto Free>
using Owned = std::unique_ptr<Thing, Freed<Free>>;

}  // namespace dccast::values
