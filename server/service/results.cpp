// Calls that read what a run or a study has computed.
#include <fcntl.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"
#include "proto/case_file/case_file.hpp"
#include "proto/case_file/quality.hpp"
#include "proto/values/digests.hpp"
#include "server/jobs/folder/job_folder.hpp"
#include "server/service/message_stream.hpp"
#include "server/service/refusals.hpp"
#include "server/service/run_history.hpp"
#include "server/service/simulation_service.hpp"

namespace dccast::service {

namespace {

/// Parses "<sequence of the event>.<step>", the place of the last step of the page before.
/// @return false: not a token of this form
bool read_token(const std::string& token, jobs::StepPlace& place) {
  if (token.empty()) return true;
  const char* end = token.data() + token.size();
  const auto [dot, first] = std::from_chars(token.data(), end, place.sequence);
  if (first != std::errc() || dot == end || *dot != '.' || place.sequence < 1) return false;

  const auto [rest, second] = std::from_chars(dot + 1, end, place.step);
  return second == std::errc() && rest == end;
}

/// Adds as many steps as fit beside what the response already holds, at least one.
void add_steps(Context& context, const v1::QueryResultRequest& request,
               v1::QueryResultResponse& response) {
  const std::size_t taken = response.ByteSizeLong();
  const std::size_t most_bytes = std::min(page_bytes, answer_bytes - std::min(answer_bytes, taken));

  jobs::StepPlace place;
  if (!read_token(request.page_token(), place))
    refuse(Remedy{"begin again without it"}, "the page_token is not one of this history");
  if (request.page_size() < 0) refuse("page_size must not be negative");

  const auto most = request.page_size() == 0 ? std::numeric_limits<std::size_t>::max()
                                             : static_cast<std::size_t>(request.page_size());

  const auto page = context.step_indexes.of(request.id())
                        ->page(*context.scheduler.log(request.id()), place, most, most_bytes);
  if (!page)
    refuse(ErrorInfo::CHANGED_MEANWHILE, Remedy{"begin again without page_token"},
           "the run has gone back behind the page before this one");

  response.mutable_steps()->Add(page->steps.begin(), page->steps.end());
  if (page->next)
    response.set_next_page_token(fmt::format("{}.{}", page->next->sequence, page->next->step));
}

/// Adds steps that are spread over the history, its last one among them.
void add_samples(Context& context, const v1::QueryResultRequest& request,
                 v1::QueryResultResponse& response) {
  constexpr int least = 2, most = 1000;
  if (request.samples() < least || request.samples() > most)
    refuse("samples is {}; permitted: 0, or {} to {}", request.samples(), least, most);

  const auto steps = context.step_indexes.of(request.id())
                         ->samples(*context.scheduler.log(request.id()),
                                   static_cast<std::size_t>(request.samples()));
  response.mutable_steps()->Add(steps.begin(), steps.end());
}

void add_frame(Context& context, const Call& call, const v1::QueryResultRequest& request,
               const v1::Job& job, v1::QueryResultResponse& response) {
  const int number = request.frame_number();
  if (number < 0) refuse("frame_number must not be negative: 1 is the first frame, 0 the last");

  const intake::FrameChoice choice{
      .number = number, .field = request.field(), .drawing = request.drawing()};
  const v1::QueryResultResponse stored = read_frame(context, call, job, choice);

  const int frames = stored.frame_time_s_size();
  if (frames == 0)
    refuse_state(
        job, artifact_of(job, results_file) ? "its results hold no frame" : "it has no frame yet");
  if (!stored.has_frame())
    refuse(ErrorInfo::OUT_OF_RANGE,
           Remedy{fmt::format("ask for one of 1 to {}, or 0 for the last", frames)},
           "job {} has {} frames", request.id(), frames);
  if (!choice.field.empty() && !stored.frame().has_field())
    refuse(ErrorInfo::NOT_FOUND, Remedy{"a frame without one names them"},
           "the frame has no field \"{}\"", choice.field);
  response.MergeFrom(stored);
}

/// Adds what only the first page carries.
void add_case_and_frame(Context& context, const Call& call, const v1::QueryResultRequest& request,
                        const v1::Job& job, v1::QueryResultResponse& response) {
  *response.mutable_findings() = job.findings();
  if (!jobs::read_complete_case(context.jobs_directory / request.id(), *response.mutable_case_()))
    refuse(ErrorInfo::DAMAGED, Remedy{"dccastd check says what else is damaged"},
           "the case of job {} cannot be read any more", request.id());
  intake::make_printable(*response.mutable_case_());
  const auto folder = context.jobs_directory / request.id();
  *response.mutable_attachments() =
      named_files(jobs::attachments_of(folder, jobs::read_job_description(folder)), request.id());
  if (request.frame()) add_frame(context, call, request, job, response);
}

std::string megabytes(std::size_t bytes) {
  return fmt::format("{} MB", (bytes + 999'999) / 1'000'000);
}

/// Refuses an answer larger than most clients accept.
void check_size(const v1::QueryResultResponse& response) {
  if (response.ByteSizeLong() <= answer_bytes) return;
  const std::size_t frame = response.has_frame() ? response.frame().ByteSizeLong() : 0;
  const std::size_t rest = response.ByteSizeLong() - frame;
  const std::string held = ", more than an answer of 4 MiB holds";
  if (frame > rest)
    refuse(ErrorInfo::ANSWER_TOO_LARGE, Remedy{"fetch results.h5, which has it too"},
           "the frame has {}{}", megabytes(frame), held);
  refuse(ErrorInfo::ANSWER_TOO_LARGE, Remedy{"fetch results.h5"}, "case and first step have {}{}",
         megabytes(rest), held);
}

void check_points(const v1::ProbeResultRequest& request) {
  constexpr int most_points = 10'000;
  if (request.points_size() < 1 || request.points_size() > most_points)
    refuse("{} points are given; 1 to {} are permitted", request.points_size(), most_points);

  for (const auto& point : request.points())
    if (!std::ranges::all_of(point.coordinate_m(), [](double c) { return std::isfinite(c); }))
      refuse("a coordinate of a point is not a finite number of metres");
}

/// The fields of the frames of a job, for messages.
std::string field_names(Context& context, const Call& call, const v1::Job& job) {
  std::vector<std::string_view> names;
  const v1::QueryResultResponse last = read_frame(context, call, job, {});
  for (const v1::FrameField& field : last.frame().fields()) names.push_back(field.name());
  return fmt::format("{}", fmt::join(names, ", "));
}

/// Refuses a probe whose points or fields do not suit the job.
void check_probed(Context& context, const Call& call, const v1::Job& job,
                  const v1::ProbeResultRequest& request, const v1::ProbeResultResponse& found) {
  if (found.dimension() == 0) refuse_state(job, "it has no frame yet");
  for (const auto& point : request.points())
    if (point.coordinate_m_size() != found.dimension())
      refuse("a point has {} coordinates; job {} is a {}", point.coordinate_m_size(), job.id(),
             found.dimension() == 2
                 ? "section: give two, x from its middle, y above the block"
                 : "slab: give three, x and y from its middle, z above the block");

  for (const v1::FrameField& field : found.fields())
    if (field.unit().empty())
      refuse(ErrorInfo::NOT_FOUND, Remedy{"there are " + field_names(context, call, job)},
             "the frames have no field \"{}\"", field.name());

  if (found.ByteSizeLong() > answer_bytes)
    refuse(ErrorInfo::ANSWER_TOO_LARGE, Remedy{"ask for fewer points, or for one instant"},
           "the values of {} points at {} instants exceed an answer of 4 MiB",
           request.points_size(), found.instants_size());
}

/// A file that is being sent to a client.
struct SentFile {
  storage::File file;
  std::string name;  ///< used in messages
  std::int64_t size = 0;
  std::string sha256{};
};

/// Sends a file in chunks, from an offset on. OUT_OF_RANGE: the offset is beyond the file's end.
class FileStream final : public MessageStream<v1::FetchResultResponse> {
public:
  using OpenFile = std::function<SentFile(const Call&)>;

  FileStream(WorkPool& pool, CallOrigin origin, std::int64_t offset, OpenFile open_file)
      : MessageStream(pool, std::move(origin)), next_(offset), open_file_(std::move(open_file)) {}

private:
  void open(const Call& call) override {
    file_ = open_file_(call);
    if (next_ < 0 || next_ > file_.size)
      refuse(ErrorInfo::OUT_OF_RANGE, Remedy{"begin again from 0"}, "{} has {} bytes", file_.name,
             file_.size);
  }

  /// Sends at least one chunk, even if empty, because size and digest travel with it.
  NextMessage<v1::FetchResultResponse> next() override {
    constexpr std::int64_t chunk_size = 256 * 1024;
    if (std::exchange(begun_, true) && next_ == file_.size) return {.end = grpc::Status::OK};

    const auto size = static_cast<std::size_t>(std::min(chunk_size, file_.size - next_));
    v1::FetchResultResponse chunk;
    chunk.set_offset(next_);
    chunk.set_total_size_bytes(file_.size);
    chunk.set_sha256(file_.sha256);
    chunk.mutable_data()->resize(size);

    if (file_.file.read_at(next_, *chunk.mutable_data()) != size)
      refuse(ErrorInfo::DAMAGED, "the file became shorter while it was read");
    next_ += static_cast<std::int64_t>(size);
    return {.message = std::move(chunk)};
  }

  std::int64_t next_;  ///< byte to be sent next
  const OpenFile open_file_;
  SentFile file_;
  bool begun_ = false;
};

/// Writes the case of a job whose client sent no file, such as Python's jobs and those of studies.
void write_case_file(const std::filesystem::path& folder, const std::filesystem::path& path) {
  v1::Case submitted;
  if (!submitted.ParseFromString(jobs::read_job_description(folder).submitted_case))
    throw std::runtime_error("the description of the job cannot be read");
  storage::write_file(path, case_file::to_toml(submitted));
}

/// Opens the case file, worker log or run facts of a job in any state, as the file is now.
SentFile open_own_file(Context& context, const v1::Job& job, const std::string& name) {
  const auto folder = context.jobs_directory / job.id();
  std::optional<jobs::CheckFolder> made;  // holds a file written for this call only

  auto path = folder / name;
  if (storage::kind_of_entry(path).empty()) {
    if (name != jobs::submitted_file)
      refuse(ErrorInfo::NOT_FOUND, "job {} has no {}: {}", job.id(), name,
             name == jobs::run_facts_file ? "no attempt of it has ended" : "it has not begun");
    made.emplace(context.query_directory, jobs::Attachments{});
    path = made->path() / name;
    write_case_file(folder, path);
  }

  // A worker may still append: digest and transfer stop at the size that the file has now.
  SentFile sent{.file = storage::File(path, O_RDONLY), .name = name};
  sent.size = sent.file.size();
  sent.sha256 = values::sha256_of_file(path, sent.size);
  return sent;
}

SentFile open_artifact(Context& context, const v1::FetchResultRequest& request) {
  const v1::Job job = find_job(context, request.id());
  if (request.artifact() == jobs::submitted_file || request.artifact() == "worker.log" ||
      request.artifact() == jobs::run_facts_file)
    return open_own_file(context, job, request.artifact());

  if (job.artifacts().empty())
    refuse_state(job, "it has no results yet: watch it until it has ended");

  const std::string name = request.artifact().empty() ? "results.h5" : request.artifact();
  const v1::Artifact* artifact = artifact_of(job, name);
  if (!artifact)
    refuse(ErrorInfo::NOT_FOUND, Remedy{"the job lists those it has"},
           "job {} has no result \"{}\"", request.id(), name);

  // The client verifies the digest, so the file is not read twice here.
  return {.file = jobs::open_result(context.jobs_directory / request.id(), *artifact),
          .name = name,
          .size = artifact->size_bytes(),
          .sha256 = artifact->sha256()};
}

/// Writes the study's table to a file that is already unlinked when the call ends. An unchanged
/// study gives the same bytes, so that a client can continue an interrupted download.
SentFile open_study(Context& context, const Call& call, const v1::FetchStudyRequest& request) {
  v1::EvaluateStudyRequest every_curve;
  every_curve.set_id(request.id());
  every_curve.set_curves(true);

  v1::WorkerRequest asked;
  *asked.mutable_write_table()->mutable_study() =
      of_study(request.id(), context.studies.evaluation().evaluate(every_curve));

  // Only a worker may load HDF5: it writes the file.
  const jobs::CheckFolder folder(context.query_directory, {});
  const auto path = folder.path() / "study.h5";
  asked.mutable_write_table()->set_path(path);
  context.warm_workers.ask(asked, waiting_time(call, context.settings.checks().timeout_s()));

  SentFile sent{.file = storage::File(path, O_RDONLY),
                .name = "the table of study " + request.id(),
                .sha256 = values::sha256_of_file(path)};
  sent.size = sent.file.size();

  if (!request.sha256().empty() && request.sha256() != sent.sha256)
    refuse(ErrorInfo::CHANGED_MEANWHILE, Remedy{"begin again from 0"},
           "the study went on meanwhile");
  return sent;
}

}  // namespace

SimulationService::Unary* SimulationService::QueryResult(Wire* wire,
                                                         const v1::QueryResultRequest* request,
                                                         v1::QueryResultResponse* response) {
  WorkPool& pool = request->frame() ? pools_.checks : pools_.histories;
  return answer(wire, *request, pool, [=, this](const Call& call) {
    const v1::Job job = find_job(context_, request->id());
    if (request->samples() != 0) return add_samples(context_, *request, *response);
    if (request->page_token().empty()) add_case_and_frame(context_, call, *request, job, *response);
    add_steps(context_, *request, *response);
    check_size(*response);
  });
}

SimulationService::Unary* SimulationService::ProbeResult(Wire* wire,
                                                         const v1::ProbeResultRequest* request,
                                                         v1::ProbeResultResponse* response) {
  return answer(wire, *request, pools_.checks, [=, this](const Call& call) {
    check_points(*request);
    const v1::Job job = find_job(context_, request->id());
    *response =
        context_.intake.probe(context_.jobs_directory / job.id(), artifact_of(job, results_file),
                              *request, waiting_time(call, context_.settings.checks().timeout_s()));
    check_probed(context_, call, job, *request, *response);
  });
}

SimulationService::Stream<v1::FetchResultResponse>* SimulationService::FetchResult(
    Wire* wire, const v1::FetchResultRequest* request) {
  return begin_stream<FileStream>(
      pools_.status, origin_of(wire, *request), request->offset(),
      [this, request = *request](const Call&) { return open_artifact(context_, request); });
}

SimulationService::Stream<v1::FetchResultResponse>* SimulationService::FetchStudy(
    Wire* wire, const v1::FetchStudyRequest* request) {
  return begin_stream<FileStream>(
      pools_.checks, origin_of(wire, *request), request->offset(),
      [this, request = *request](const Call& call) { return open_study(context_, call, request); });
}

}  // namespace dccast::service
