// Writes a sample result file and its sidecar for external tools: write_sample_run FOLDER
#include <iostream>

#include "tests/unit/results/sample_run.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: write_sample_run FOLDER\n";
    return 2;
  }
  using namespace dccast::results;
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const int nodes_per_element : {3, 4}) {
    const std::string name = nodes_per_element == 3 ? "triangles" : "quadrilaterals";
    ResultWriter writer({folder / (name + ".journal"), folder / (name + ".h5")}, sample_header());
    writer.append(sample_frame(0, nodes_per_element, 4));
    for (std::int64_t step = 1; step <= 300; ++step) {
      writer.append(sample_step(step));
      if (step % 100 == 0) {
        const int cells = 4 * static_cast<int>(step);  // the last ones long enough to be compressed
        writer.append(sample_frame(step, nodes_per_element, cells));
      }
    }
    writer.publish({});
    std::filesystem::remove(folder / (name + ".journal"));
  }
  ResultWriter writer({folder / "hexahedra.journal", folder / "hexahedra.h5"},
                      sample_solid_header());
  writer.append(sample_solid_frame(0, 5));
  writer.append(sample_solid_step(1));
  writer.append(sample_solid_frame(1, 1200));
  writer.publish({});
  std::filesystem::remove(folder / "hexahedra.journal");
}
