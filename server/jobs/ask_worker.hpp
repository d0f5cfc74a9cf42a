#pragma once

#include <chrono>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>

namespace dccast::jobs {

/// The worker program died over a question, took too long or could not be started.
class WorkerDidNotAnswer : public std::runtime_error {
public:
  using std::runtime_error::runtime_error;
};

/// Asks the worker program one question, in a process of its own: a mesh or a result file that
/// brings it down or keeps it busy for ever costs one answer, not the daemon.
/// @param mode      "--check" or "--frame", see server/worker/main.cpp
/// @param question  on its standard input
/// @return          its standard output
/// @throws WorkerDidNotAnswer
std::string ask_worker(const std::filesystem::path& worker_program, const std::string& mode,
                       std::string_view question, std::chrono::seconds timeout);

}  // namespace dccast::jobs
