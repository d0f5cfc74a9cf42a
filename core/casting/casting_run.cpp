#include "core/casting/casting_run.hpp"

#include "core/casting/slab_run.hpp"

namespace dccast::casting {

std::unique_ptr<CastingRun> make_run(const Case& c, int threads) {
  if (mesh::dimension_of(c.section.kind) == 2) return std::make_unique<SlabRun<2>>(c);
  return std::make_unique<SlabRun<3>>(c, threads);
}

}  // namespace dccast::casting
