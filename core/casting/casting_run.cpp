#include "core/casting/casting_run.hpp"

#include <stdexcept>

#include "core/casting/slab_run.hpp"

namespace dccast::casting {

std::unique_ptr<CastingRun> make_run(const Case& c) {
  if (mesh::dimension_of(c.section.kind) == 2) return std::make_unique<SlabRun<2>>(c);
  throw std::logic_error("make_run: a section of three dimensions");
}

}  // namespace dccast::casting
