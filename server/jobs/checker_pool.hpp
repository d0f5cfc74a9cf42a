#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/checker.hpp"

namespace dccast::jobs {

struct CheckerLimits {
  std::string option = "--serve-checks";  ///< of the program, or --serve-queries
  int kept = 1;        ///< checkers that stay while nobody asks
  int answers = 1000;  ///< after which a checker is replaced, so that leaks do not add up
  std::int64_t idle_bytes = 512'000'000;       ///< one that holds more after an answer is replaced
  std::int64_t largest_bytes = 4'000'000'000;  ///< one that takes more for an answer is killed
};

/// Checkers kept warm: starting the worker program takes 30 ms, an answer less than one, and one
/// that was killed or worn out is replaced before it is missed. Safe to
/// use from several threads; each question that is under way has a checker of its own, so a caller
/// decides how many there are.
class CheckerPool {
public:
  explicit CheckerPool(std::filesystem::path worker_program, CheckerLimits limits = {});

  /// Starts as many as are kept. @throws WorkerDidNotAnswer
  void warm_up();
  /// @throws WorkerDidNotAnswer
  std::string ask(
      Question question, std::string_view text, const Patience& patience,
      const OnPart& on_part = [](std::string_view) {});

private:
  std::unique_ptr<Checker> start() const;
  std::unique_ptr<Checker> take();
  void give_back(std::unique_ptr<Checker> checker);
  void keep(std::unique_ptr<Checker> checker);
  void replace() noexcept;

  const std::filesystem::path worker_program_;
  const CheckerLimits limits_;
  std::mutex mutex_;
  std::vector<std::unique_ptr<Checker>> idle_;
};

}  // namespace dccast::jobs
