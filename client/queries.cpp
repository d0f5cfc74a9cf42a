#include "client/queries.hpp"

#include <algorithm>
#include <chrono>
#include <future>
#include <memory>

namespace dccast::client {
namespace {

constexpr std::size_t at_once = 8;
constexpr std::chrono::milliseconds look{20};  // interval between checks for an interruption

/// One query in a thread, with an interruption of its own.
class Question {
public:
  Question(const std::string& server, CaseUnderCheck& checked)
      : answer_(std::async(std::launch::async, [server, own = own_, &checked] {
          Connection connection(server, own);
          return ask_query(connection, checked, false);
        })) {}
  Question(Question&&) = default;
  ~Question() {
    if (answer_.valid()) own_->come();  // another query has failed: this answer is no longer needed
  }

  /// Rethrows the exception of the query.
  std::optional<Answer> answer(const Interruption& command) {
    while (answer_.wait_for(look) != std::future_status::ready)
      if (command.came()) own_->come();
    return answer_.get();
  }

private:
  std::shared_ptr<Interruption> own_ = std::make_shared<Interruption>();
  std::future<std::optional<Answer>> answer_;
};

}  // namespace

std::vector<std::optional<Answer>> ask_queries(Connection& connection,
                                               std::vector<CaseUnderCheck>& cases) {
  std::vector<std::optional<Answer>> answers;
  while (answers.size() < cases.size()) {
    std::vector<Question> questions;
    const std::size_t end = std::min(cases.size(), answers.size() + at_once);
    for (std::size_t i = answers.size(); i < end; ++i)
      questions.emplace_back(connection.server(), cases[i]);
    for (Question& question : questions)
      answers.push_back(question.answer(connection.interruption()));
  }
  return answers;
}

}  // namespace dccast::client
