#include "client/text/top_page.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include <fmt/core.h>

#include "client/session/jobs.hpp"
#include "client/text/job_text.hpp"
#include "client/text/progress.hpp"
#include "client/text/table.hpp"
#include "client/text/terminal.hpp"

namespace dccast::client {
namespace {

std::string megabytes(std::int64_t bytes) {
  return fixed(1e-6 * static_cast<double>(bytes), 0) + " MB";
}

std::string bar(double progress) {
  constexpr int width = 12;
  const int full = std::clamp(static_cast<int>(std::lround(width * progress)), 0, width);
  return "[" + std::string(full, '#') + std::string(width - full, '.') + "] " +
         fixed(100.0 * progress, 0) + " %";
}

std::string running_table(const TopView& view) {
  std::vector<std::string> ids;
  for (const v1::Job& job : view.running) ids.push_back(job.id());
  const std::size_t length = short_id_length(ids);
  Table table({"JOB", "OWNER", "DONE", ">LEFT", ">CURL mm", "TITLE"});
  for (const v1::Job& job : view.running)
    table.add({job.id().substr(0, length), job.owner(), bar(job.last_step().progress()),
               job.has_ends_in_s() ? duration_text(job.ends_in_s()) : "-", judged_curl_text(job),
               job.title() + (job.held().empty() ? "" : " (" + job.held() + ")")});
  return table.text();
}

std::string queue_table(const TopView& view, std::int64_t now_unix) {
  struct Waiting {
    int jobs = 0, first = 0;
    double starts_in_s = NAN;
    std::int64_t oldest = INT64_MAX;
  };

  std::map<std::string, Waiting> owners;
  for (const v1::Job& job : view.queued) {
    Waiting& waiting = owners[job.owner()];
    ++waiting.jobs;
    waiting.oldest = std::min(waiting.oldest, job.create_time().seconds());
    const int position = job.queue_position();
    if (position == 0 || (waiting.first != 0 && position > waiting.first)) continue;
    waiting.first = position;
    waiting.starts_in_s = job.has_starts_in_s() ? job.starts_in_s() : NAN;
  }

  Table table({"OWNER", ">QUEUED", ">NEXT", ">STARTS IN", ">OLDEST"});
  for (const auto& [owner, waiting] : owners)
    table.add(
        {owner.empty() ? "-" : owner, std::to_string(waiting.jobs),
         waiting.first == 0 ? "-" : "#" + std::to_string(waiting.first),
         std::isfinite(waiting.starts_in_s) ? start_text(waiting.starts_in_s) : "-",
         duration_text(static_cast<double>(std::max<std::int64_t>(0, now_unix - waiting.oldest)))});
  return table.text();
}

}  // namespace

std::string top_page(const TopView& view, int columns, int lines, std::int64_t now_unix) {
  const v1::GetServerInfoResponse& about = view.about;
  std::string page = fmt::format(
      "dccastd {} on {}: {} of {} running, {} queued, {} paused\n"
      "memory: daemon {}, {} workers {}\n",
      about.version(), view.server, about.running(), about.workers(), about.queued(),
      about.paused(), megabytes(about.memory_bytes()), about.worker_processes(),
      megabytes(about.worker_memory_bytes()));

  if (!about.storage_fault().empty()) page += "held: " + about.storage_fault() + "\n";
  page += "\n" + (view.running.empty() ? "no job runs\n" : running_table(view));
  if (!view.queued.empty()) page += "\n" + queue_table(view, now_unix);
  if (about.queued() > static_cast<int>(view.queued.size()) && !view.queued.empty())
    page += fmt::format("the newest {} of the queue\n", view.queued.size());

  std::istringstream all(page);
  std::string shown;
  int count = 0;
  for (std::string line; std::getline(all, line) && (lines == 0 || count < lines); ++count)
    shown += cut_to(line, columns) + "\n";
  return shown;
}

}  // namespace dccast::client
