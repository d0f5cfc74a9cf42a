#include "server/worker/main.hpp"

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <filesystem>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>

#include "core/case/case_check.hpp"
#include "core/casting/simulation.hpp"
#include "core/casting/stored_run.hpp"
#include "core/findings/judge.hpp"
#include "core/results/result_reader.hpp"
#include "core/results/study_table.hpp"
#include "dccast/v1/service.pb.h"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/checker.hpp"
#include "server/jobs/job_folder.hpp"
#include "server/translate/case_to_core.hpp"
#include "server/translate/to_proto.hpp"
#include "server/worker/run_job.hpp"

namespace dccast::worker {

namespace {

constexpr int exit_closed = 0;
constexpr int exit_link_broken = 1;

/// @return whether all of `bytes` came
bool receive(int socket, void* bytes, std::size_t size) {
  if (size == 0) return true;  // recv() would wait for the bytes of the next question
  ssize_t received;
  do received = ::recv(socket, bytes, size, MSG_WAITALL);
  while (received < 0 && errno == EINTR);
  return received == static_cast<ssize_t>(size);
}

bool send(int socket, std::string_view bytes) {
  while (!bytes.empty()) {
    const auto sent = ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent < 0 && errno != EINTR) return false;
    if (sent > 0) bytes.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

v1::ValidateCaseResponse checked(const v1::WorkerOrder& start, const casting::Case& c) {
  return translate::to_proto(
      casting::check(c, {start.faulty_keys().begin(), start.faulty_keys().end()}));
}

bool send_piece(int socket, std::uint32_t kind, const std::string& text) {
  const std::array<std::uint32_t, 2> head{kind, static_cast<std::uint32_t>(text.size())};
  std::string piece(reinterpret_cast<const char*>(head.data()), sizeof head);
  piece += text;
  return send(socket, piece);
}

/// A query's run: every event is a part of the answer. Who wants no more of it kills this
/// process.
class PartsOfAnswer : public RunLink {
public:
  explicit PartsOfAnswer(int socket) : socket_(socket) {}
  void send(v1::JobEvent event) override {
    if (!send_piece(socket_, jobs::answer_part, event.SerializeAsString()))
      ::_exit(exit_link_broken);
  }
  casting::Order order() const override { return casting::Order::go_on; }

private:
  int socket_;
};

std::string run_query(int socket, const v1::WorkerOrder& start, Results results) {
  PartsOfAnswer parts(socket);
  return run_job(start, parts, results).SerializeAsString();
}

casting::Case case_of(const v1::WorkerOrder& start) {
  const std::filesystem::path folder = start.directory();
  return translate::to_core(start.case_(), folder / jobs::attachments_folder);
}

std::string check(const v1::WorkerOrder& start) {
  return checked(start, case_of(start)).SerializeAsString();
}

/// Whether a case that can be run is one that a plant could run.
std::string judge(const v1::WorkerOrder& start) {
  const casting::Case c = case_of(start);
  v1::ValidateCaseResponse verdict = checked(start, c);
  if (verdict.faults_size() > 0 || start.faulty_keys_size() > 0) return verdict.SerializeAsString();
  for (const auto& found : {casting::findings_of_case(c), casting::forecast(c)})
    for (const results::Finding& finding : found)
      *verdict.add_findings() = translate::to_proto(finding);
  return verdict.SerializeAsString();
}

std::string stored_frame(const std::string& text) {
  std::istringstream words(text);
  std::size_t number = 0;
  words >> number >> std::ws;
  std::string folder;
  std::getline(words, folder);
  const results::ResultReader reader(std::filesystem::path(folder) / "results.h5");
  v1::QueryResultResponse found;
  const auto times = reader.frame_times();
  found.mutable_frame_time_s()->Add(times.begin(), times.end());
  if (number == 0) number = times.size();
  if (number >= 1 && number <= times.size())
    *found.mutable_frame() = translate::to_proto(reader.frame(number - 1), reader.header());
  return found.SerializeAsString();
}

std::string write_table(const std::string& text) {
  const std::size_t end_of_path = text.find('\n');
  v1::StudyResult result;
  if (end_of_path == std::string::npos || !result.ParseFromString(text.substr(end_of_path + 1)))
    throw std::runtime_error("the study cannot be read");
  results::write_study_table(text.substr(0, end_of_path), translate::to_table(result));
  return {};
}

std::string answer(int socket, jobs::Question question, const std::string& text) {
  if (question == jobs::Question::solver) return casting::solver_identity();
  if (question == jobs::Question::frame) return stored_frame(text);
  if (question == jobs::Question::study_table) return write_table(text);
  v1::WorkerOrder start;
  if (!start.ParseFromString(text)) throw std::runtime_error("the question cannot be read");
  switch (question) {
    case jobs::Question::check:
      return check(start);
    case jobs::Question::judge:
      return judge(start);
    case jobs::Question::query:
      return run_query(socket, start, Results::discarded);
    case jobs::Question::kept_query:
      return run_query(socket, start, Results::kept);
    case jobs::Question::frame:
    case jobs::Question::solver:
    case jobs::Question::study_table:
      break;  // answered above
  }
  throw std::runtime_error("there is no such question");
}

/// @return whether the answer, or why there is none, could be sent
bool answer_next(int socket, jobs::Question question, const std::string& text) {
  try {
    return send_piece(socket, jobs::answer_end, answer(socket, question, text));
  } catch (const std::exception& error) {
    return send_piece(socket, jobs::answer_refused, error.what());
  }
}

}  // namespace

int serve_checks(int socket) {
  std::array<std::uint32_t, 2> head;
  while (receive(socket, head.data(), sizeof head)) {
    std::string text(head[1], '\0');
    if (!receive(socket, text.data(), text.size())) return exit_link_broken;
    if (!answer_next(socket, static_cast<jobs::Question>(head[0]), text)) return exit_link_broken;
  }
  return exit_closed;
}

}  // namespace dccast::worker
