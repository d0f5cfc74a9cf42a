#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "core/storage/file.hpp"

namespace dccast::jobs {

/// What the daemon does not answer in its own process. Each is asked with a serialised
/// WorkerOrder, unless noted, and answered with a serialised message.
enum class Question : std::uint32_t {
  check = 1,  ///< a ValidateCaseResponse on its case
  judge = 3,  ///< the same with the findings of a case without faults, which takes longer
  /// Asked with "NUMBER FOLDER": a QueryResultResponse with the times of the frames that the
  /// results in the folder hold, and with that frame, if there is one. 1 is the first, 0 the last.
  frame = 2,
  /// A run of its case: a JobEvent of each step as a part, the answer is its RunEnd.
  query = 6,
  kept_query = 4,  ///< the same; RunEnd names the results in its directory
  solver = 5,      ///< no case; the solver's identity, as text
  /// Asked with the path of a file to be written, a line break and a serialised StudyResult with
  /// curves; no answer but the file, HDF5, see docs/studies.md.
  study_table = 7,
};

/// What an answer has before its end: a serialised message.
using OnPart = std::function<void(std::string_view)>;

// What a piece of an answer is.
inline constexpr std::uint32_t answer_end = 0;
inline constexpr std::uint32_t answer_refused = 1;
inline constexpr std::uint32_t answer_part = 2;

/// A question got no answer.
class WorkerDidNotAnswer : public std::runtime_error {
public:
  enum class Why {
    not_started,  ///< the program cannot be started, or not now
    died,         ///< the question brought it down
    killed,       ///< somebody killed it, e.g. the system when memory ran out
    refused,      ///< it gives a reason why it cannot answer, or its answer cannot be read
    too_slow,     ///< past the deadline; it was killed
    too_large,    ///< it took more memory than it may; it was killed
    called_off,   ///< no one waits for the answer any more; it was killed
  };
  WorkerDidNotAnswer(Why why, const std::string& what) : std::runtime_error(what), why_(why) {}
  Why why() const { return why_; }

private:
  Why why_;
};

/// How long a question may take and who still wants its answer.
struct CallLimits {
  std::chrono::steady_clock::time_point deadline;
  std::function<bool()> called_off = [] { return false; };
};

/// One process of the worker program that answers question after question: a mesh or a result file
/// that brings it down or keeps it busy forever costs one answer, not the daemon.
///
/// Both ends speak over a socket: a question is its number and its length, 4 bytes each in the
/// machine's order, then as many bytes; an answer is any number of parts and an end, each a number
/// (0 answered, 1 the text says why not, 2 a part) and its length, then as many bytes.
class Checker {
public:
  /// @param option         of the program; both options answer the same, lists of processes show
  /// which
  /// @param largest_bytes  of memory that it may take for one answer
  /// @throws WorkerDidNotAnswer  it cannot be started
  Checker(const std::filesystem::path& worker_program, const std::string& option,
          std::int64_t largest_bytes);
  Checker(const Checker&) = delete;
  /// Kills the process.
  ~Checker();

  /// @throws WorkerDidNotAnswer  save for `refused`, this checker must not be asked again then
  std::string ask(
      Question question, std::string_view text, const CallLimits& limits,
      const OnPart& on_part = [](std::string_view) {});

  /// Whether nothing has happened to it while it waited.
  bool waits() const;
  int answers() const { return answers_; }
  std::int64_t resident_bytes() const;

private:
  void wait_until(short events, const CallLimits& limits) const;
  void send(std::string_view bytes, const CallLimits& limits);
  std::uint32_t receive_piece(std::string& text, const CallLimits& limits);
  void receive(std::string& bytes, const CallLimits& limits);
  [[noreturn]] void report_death();

  std::string name_;
  std::int64_t largest_bytes_;
  storage::FileDescriptor socket_;
  pid_t process_ = 0;  ///< 0: collected
  int answers_ = 0;
};

struct CheckerLimits {
  std::string option = "--serve-checks";  ///< of the program, or --serve-queries
  int kept = 1;                           ///< checkers that stay while no one asks
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
      Question question, std::string_view text, const CallLimits& limits,
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
