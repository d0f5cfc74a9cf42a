#include <stdexcept>

#include "tests/verification/program/casting_history.hpp"
#include "tests/verification/program/discussion.hpp"

// Castings in a build of the core alone.
namespace dccast::verification {

bool has_casting_table() {
  return false;
}

Table casting_table(const TableOptions&) {
  throw std::logic_error("table 11 needs case files, which this build is without");
}

std::string casting_figures(const TableOptions&) {
  throw std::logic_error("figures of castings need case files, which this build is without");
}

ElementComparison compare_elements(const TableOptions&) {
  throw std::logic_error("`elements` needs case files, which this build is without");
}

void HistoryRequest::add_to(CLI::App&) {}

bool write_history(const HistoryRequest&) {
  throw std::logic_error("`history` needs case files, which this build is without");
}

}  // namespace dccast::verification
