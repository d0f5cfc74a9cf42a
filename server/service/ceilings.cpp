#include "server/service/ceilings.hpp"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

namespace dccast::service {

namespace {

std::string gigabytes(double bytes) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g GB", bytes * 1e-9);
  return text;
}

void add_fault(v1::ValidateCaseResponse& verdict, const char* field, const std::string& value,
               const std::string& most, const std::string& setting, const std::string& remedy) {
  v1::Fault& fault = *verdict.add_faults();
  fault.set_field(field);
  fault.set_value(value);
  fault.set_message("the case has " + value + ", more than this dccastd takes");
  fault.set_permitted("at most " + most);
  fault.set_remedy(remedy + ", or have " + setting + " raised in the settings of dccastd");
}

}  // namespace

double memory_per_worker(int workers) {
  double memory =
      static_cast<double>(::sysconf(_SC_PHYS_PAGES)) * static_cast<double>(::sysconf(_SC_PAGESIZE));
  std::ifstream group("/sys/fs/cgroup/memory.max");
  if (double permitted = 0.0; group >> permitted) memory = std::min(memory, permitted);
  return 0.9 * memory / std::max(workers, 1);
}

void hold_against(const Ceilings& ceilings, v1::ValidateCaseResponse& verdict) {
  if (!verdict.has_estimate()) return;
  const auto& estimate = verdict.estimate();
  const char* coarser = "make the mesh coarser";
  if (estimate.nodes() > ceilings.nodes)
    add_fault(verdict, "mesh", std::to_string(estimate.nodes()) + " nodes at its end",
              std::to_string(ceilings.nodes), "maximum_nodes", coarser);
  if (estimate.steps() > ceilings.steps)
    add_fault(verdict, "time", std::to_string(estimate.steps()) + " steps",
              std::to_string(ceilings.steps), "maximum_steps", "take longer steps");
  if (estimate.memory_bytes() > ceilings.memory_bytes)
    add_fault(verdict, "mesh", gigabytes(estimate.memory_bytes()) + " of estimated memory",
              gigabytes(ceilings.memory_bytes), "maximum_memory", coarser);
  if (verdict.faults_size() > 0) verdict.clear_estimate();
}

}  // namespace dccast::service
