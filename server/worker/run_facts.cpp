#include "server/worker/run_facts.hpp"

#include <fmt/chrono.h>
#include <google/protobuf/util/json_util.h>
#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/worker/run_facts.pb.h"

namespace dccast::worker {
namespace {

/// "AMD EPYC 7763 64-Core Processor"; "unknown" where the system does not name it.
std::string processor_name() {
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);)
    if (const auto colon = line.find(": "); line.starts_with("model name") && colon != line.npos)
      return line.substr(colon + 2);
  return "unknown";
}

std::string system_name() {
  utsname name{};
  if (::uname(&name) != 0) return "unknown";
  return fmt::format("{} {} {}", name.sysname, name.release, name.machine);
}

std::string utc(std::chrono::system_clock::time_point at) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}",
                     fmt::gmtime(std::chrono::system_clock::to_time_t(at)));
}

double seconds(std::chrono::system_clock::duration duration) {
  return std::chrono::duration<double>(duration).count();
}

}  // namespace

void write_run_facts(const v1::SolveCase& order, const std::filesystem::path& folder,
                     std::chrono::system_clock::time_point begin) {
  try {
    const auto end = std::chrono::system_clock::now();
    RunFacts facts;
    facts.set_job(order.job_id());
    facts.set_attempt(order.attempt());
    facts.set_program_version(DCCAST_VERSION);
    facts.set_commit(commit);
    facts.set_case_sha256(jobs::read_job_description(folder).job.case_sha256());
    facts.set_processor(processor_name());
    facts.set_cores(static_cast<int>(std::thread::hardware_concurrency()));
    facts.set_threads(std::max(order.threads(), 1));
    facts.set_system(system_name());
    facts.set_begin(utc(begin));
    facts.set_end(utc(end));
    facts.set_wall_s(seconds(end - begin));
    facts.set_processor_s(static_cast<double>(std::clock()) / CLOCKS_PER_SEC);

    std::string text;
    google::protobuf::util::JsonPrintOptions options;
    options.add_whitespace = options.preserve_proto_field_names = true;
    options.always_print_primitive_fields = true;
    if (google::protobuf::util::MessageToJsonString(facts, &text, options).ok())
      storage::write_file(folder / jobs::run_facts_file, text);
  } catch (const std::exception& error) {
    std::cerr << "dccast-worker: " << jobs::run_facts_file << " is not written: " << error.what()
              << std::endl;
  }
}

}  // namespace dccast::worker
