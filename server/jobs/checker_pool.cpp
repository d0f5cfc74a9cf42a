#include "server/jobs/checker_pool.hpp"

#include <utility>

namespace dccast::jobs {

CheckerPool::CheckerPool(std::filesystem::path worker_program, CheckerLimits limits)
    : worker_program_(std::move(worker_program)), limits_(std::move(limits)) {}

void CheckerPool::warm_up() {
  for (int i = 0; i < limits_.kept; ++i) give_back(start());
}

std::string CheckerPool::ask(Question question, std::string_view text, const Patience& patience,
                             const OnPart& on_part) {
  auto checker = take();
  try {
    std::string answer = checker->ask(question, text, patience, on_part);
    give_back(std::move(checker));
    return answer;
  } catch (const WorkerDidNotAnswer& error) {
    if (error.why() == WorkerDidNotAnswer::Why::refused) {
      give_back(std::move(checker));
    } else {
      checker.reset();  // first: two at once may be one too many for the memory
      replace();
    }
    throw;
  }
}

/// Starts one more, if fewer than are kept wait. One that cannot be started now is tried again when
/// it is needed, and said then.
void CheckerPool::replace() noexcept {
  try {
    {
      const std::lock_guard lock(mutex_);
      if (static_cast<int>(idle_.size()) >= limits_.kept) return;
    }
    keep(start());
  } catch (const std::exception&) {
  }
}

std::unique_ptr<Checker> CheckerPool::start() const {
  return std::make_unique<Checker>(worker_program_, limits_.option, limits_.largest_bytes);
}

std::unique_ptr<Checker> CheckerPool::take() {
  for (;;) {
    std::unique_ptr<Checker> checker;
    {
      const std::lock_guard lock(mutex_);
      if (idle_.empty()) break;
      checker = std::move(idle_.back());
      idle_.pop_back();
    }
    if (checker->waits()) return checker;
  }
  return start();
}

void CheckerPool::give_back(std::unique_ptr<Checker> checker) {
  const bool worn =
      checker->answers() >= limits_.answers || checker->resident_bytes() > limits_.idle_bytes;
  if (!worn) return keep(std::move(checker));
  checker.reset();
  replace();
}

void CheckerPool::keep(std::unique_ptr<Checker> checker) {
  const std::lock_guard lock(mutex_);
  if (static_cast<int>(idle_.size()) < limits_.kept) idle_.push_back(std::move(checker));
}

}  // namespace dccast::jobs
