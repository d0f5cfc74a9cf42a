#include "server/worker/run_facts.hpp"

#include <fmt/chrono.h>
#include <google/protobuf/struct.pb.h>
#include <google/protobuf/util/json_util.h>
#include <sys/utsname.h>

#include <ctime>
#include <fstream>
#include <iostream>
#include <string>
#include <thread>

#include "core/storage/file.hpp"
#include "server/jobs/folder/job_folder.hpp"

namespace dccast::worker {
namespace {

using Fields = google::protobuf::Map<std::string, google::protobuf::Value>;

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
    google::protobuf::Struct facts;
    Fields& fields = *facts.mutable_fields();
    fields["job"].set_string_value(order.job_id());
    fields["attempt"].set_number_value(order.attempt());
    fields["program_version"].set_string_value(DCCAST_VERSION);
    fields["commit"].set_string_value(commit);
    fields["case_sha256"].set_string_value(jobs::read_job_description(folder).job.case_sha256());
    fields["processor"].set_string_value(processor_name());
    fields["cores"].set_number_value(std::thread::hardware_concurrency());
    fields["threads"].set_number_value(std::max(order.threads(), 1));
    fields["system"].set_string_value(system_name());
    fields["begin"].set_string_value(utc(begin));
    fields["end"].set_string_value(utc(end));
    fields["wall_s"].set_number_value(seconds(end - begin));
    fields["processor_s"].set_number_value(static_cast<double>(std::clock()) / CLOCKS_PER_SEC);

    std::string text;
    google::protobuf::util::JsonPrintOptions options;
    options.add_whitespace = true;
    if (google::protobuf::util::MessageToJsonString(facts, &text, options).ok())
      storage::write_file(folder / jobs::run_facts_file, text);
  } catch (const std::exception& error) {
    std::cerr << "dccast-worker: " << jobs::run_facts_file << " is not written: " << error.what()
              << std::endl;
  }
}

}  // namespace dccast::worker
