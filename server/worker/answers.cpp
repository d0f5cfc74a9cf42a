#include "server/worker/answers.hpp"

#include <filesystem>
#include <iostream>
#include <stdexcept>

#include "core/casting/case_check.hpp"
#include "core/results/result_reader.hpp"
#include "dccast/v1/worker.pb.h"
#include "server/jobs/job_folder.hpp"
#include "server/translate/case_to_core.hpp"
#include "server/translate/faults_to_proto.hpp"
#include "server/translate/frame_to_proto.hpp"

namespace dccast::worker {

namespace {

v1::WorkerOrder::Start read(std::istream& question) {
  v1::WorkerOrder::Start start;
  if (!start.ParseFromIstream(&question)) throw std::runtime_error("the question cannot be read");
  return start;
}

int write(const google::protobuf::Message& message, std::ostream& answer) {
  if (!message.SerializeToOstream(&answer) || !answer.flush())
    throw std::runtime_error("the answer cannot be written");
  return 0;
}

}  // namespace

int answer_check(std::istream& question, std::ostream& answer) {
  const auto start = read(question);
  const std::filesystem::path folder = start.directory();
  const auto checked =
      casting::check(translate::to_core(start.case_(), folder / jobs::attachments_folder),
                     {start.faulty_keys().begin(), start.faulty_keys().end()});
  return write(translate::to_proto(checked), answer);
}

int answer_frame(std::istream& question, std::ostream& answer) {
  const std::filesystem::path folder = read(question).directory();
  const results::ResultReader reader(folder / "results.h5");
  const auto frame = reader.last_frame();
  if (!frame) throw std::runtime_error("the results hold no frame");
  return write(translate::to_proto(*frame, reader.header()), answer);
}

}  // namespace dccast::worker
