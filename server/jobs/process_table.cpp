#include "server/jobs/process_table.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace dccast::jobs {

namespace {

namespace fs = std::filesystem;

std::int64_t resident_bytes(const std::string& process) {
  std::ifstream file("/proc/" + process + "/statm");
  std::int64_t pages = 0, resident = 0;
  file >> pages >> resident;
  return resident * ::sysconf(_SC_PAGESIZE);
}

}  // namespace

std::map<std::string, ProcessTotals> child_processes() {
  std::map<std::string, ProcessTotals> totals;
  std::error_code error;
  for (fs::directory_iterator task("/proc/self/task", error), end; !error && task != end;
       task.increment(error)) {
    std::ifstream children(task->path() / "children");
    for (std::string process; children >> process;) {
      std::string name;
      std::getline(std::ifstream("/proc/" + process + "/comm"), name);
      if (name.empty()) continue;  // it has ended
      ProcessTotals& total = totals[name];
      ++total.number;
      total.resident_bytes += resident_bytes(process);
    }
  }
  return totals;
}

std::int64_t own_resident_bytes() {
  return resident_bytes("self");
}

}  // namespace dccast::jobs
