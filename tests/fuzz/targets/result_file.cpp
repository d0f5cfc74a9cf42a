// results.h5, as a worker reads a frame of it for a client.
#include "core/results/result_reader.hpp"
#include "core/storage/storage_error.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace dccast;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const auto& path = fuzz::file_with(fuzz::text_of(bytes, size));
  try {
    const results::ResultReader reader(path);
    reader.header();
    reader.summary();
    reader.history();
    const auto times = reader.frame_times();
    for (std::size_t i = 0; i < std::min<std::size_t>(times.size(), 4); ++i) reader.frame(i);
  } catch (const storage::StorageError&) {
  }
  return 0;
}
