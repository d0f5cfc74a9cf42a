#include "core/casting/stored_run.hpp"

#include <stdexcept>

#include "core/linalg/tile_kernels.hpp"
#include "core/results/checkpoint_file.hpp"
#include "core/results/result_writer.hpp"

namespace dccast::casting {

extern const char core_sources[];  // written by hash_sources.cmake when a source has changed

const std::string& solver_identity() {
  static const std::string identity = std::string("dccast ") + DCCAST_VERSION + ", g++ " +
                                      __VERSION__ + ", " + linalg::best_tile_kernels().name +
                                      ", state 6, sources " + core_sources;
  return identity;
}

namespace {

using results::Sections;

StoredRun none(const std::string& reason) {
  StoredRun stored;
  stored.reason = reason;
  return stored;
}

StoredRun of_other_version(const std::string& whose) {
  StoredRun stored = none("it is of another version: " + whose);
  stored.other_version = true;
  return stored;
}

/// @throws std::out_of_range  a section is missing
StoredRun taken(const Sections& s, const CheckpointOrigin& origin) {
  if (!s.has("solver")) return of_other_version("one without an identity");
  if (s.text("solver") != origin.solver)
    return of_other_version(s.text("solver") + "; this is " + origin.solver);
  if (s.text("case") != origin.case_json) return none("it is of another case");
  if (!s.has(results::journal_records)) return none("it does not say how long the journal was");
  StoredRun stored;
  stored.content = s;
  stored.step = s.integer("step");
  stored.journal_records = s.integer(results::journal_records);
  return stored;
}

}  // namespace

void sign(Sections& state, const CheckpointOrigin& origin) {
  state.set("solver", origin.solver);
  state.set("case", origin.case_json);
}

StoredRun read_stored_run(const std::filesystem::path& checkpoint, const CheckpointOrigin& origin) {
  const results::CheckpointRead read = results::read_checkpoint(checkpoint);
  if (read.other_format) return of_other_version(read.reason);
  if (!read.content) return none(read.reason);
  try {
    return taken(*read.content, origin);
  } catch (const std::out_of_range& error) {
    return none(std::string("it is incomplete: ") + error.what());
  }
}

}  // namespace dccast::casting
