#include "server/daemon/metrics.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>
#include <vector>

#include "core/storage/file.hpp"
#include "proto/http/server.hpp"
#include "proto/values/address.hpp"
#include "proto/values/printable.hpp"
#include "server/access/certificates.hpp"
#include "server/access/users.hpp"
#include "server/jobs/folder/events.hpp"
#include "server/jobs/folder/quarantine.hpp"
#include "server/jobs/log.hpp"
#include "server/jobs/processes.hpp"
#include "server/service/forecasts.hpp"

namespace dccast::daemon {

namespace {

using Label = std::pair<const char*, std::string>;
using Labels = std::vector<Label>;

/// @return `{state="QUEUED"}`; empty for none
std::string to_text(const Labels& labels) {
  std::string text;
  for (const auto& [name, value] : labels)
    text += fmt::format("{}{}=\"{}\"", text.empty() ? "{" : ",", name,
                        values::escaped_in_quotes(value));
  return text.empty() ? text : text + "}";
}

/// Writes the text format of Prometheus. It is simple; prometheus-cpp would add a web server and
/// two libraries.
class Exposition {
public:
  void begin(const char* name, const char* type, const char* help) {
    name_ = name;
    text_ += fmt::format("# HELP {} {}\n# TYPE {} {}\n", name, help, name, type);
  }
  template <class Number>
  void sample(Number value, const Labels& labels = {}, const char* suffix = "") {
    text_ += fmt::format("{}{}{} {}\n", name_, suffix, to_text(labels), static_cast<double>(value));
  }
  template <class Number>
  void gauge(const char* name, const char* help, Number value) {
    begin(name, "gauge", help);
    sample(value);
  }
  void histogram(const jobs::Histogram& histogram, const Labels& labels = {}) {
    const std::string own = to_text(labels);
    const std::string before = own.empty() ? "{" : own.substr(0, own.size() - 1) + ",";
    std::uint64_t so_far = 0;
    for (std::size_t i = 0; i < histogram.bounds.size(); ++i)
      text_ += fmt::format("{}_bucket{}le=\"{}\"}} {}\n", name_, before, histogram.bounds[i],
                           so_far += histogram.counts[i]);
    text_ += fmt::format("{}_bucket{}le=\"+Inf\"}} {}\n", name_, before, histogram.count);
    sample(histogram.sum, labels, "_sum");
    sample(histogram.count, labels, "_count");
  }
  std::string text() && { return std::move(text_); }

private:
  std::string name_, text_;
};

double seconds_since(std::int64_t since_ms) {
  return 1e-3 *
         static_cast<double>(std::max<std::int64_t>(0, jobs::milliseconds(jobs::now()) - since_ms));
}

/// Values by owner. If names of users must not be shown, it sums them to one sample without a
/// label.
template <class Value>
class ByOwner {
public:
  explicit ByOwner(bool shows_owners) : shows_owners_(shows_owners) {}
  void add(const std::string& owner, Value value) {
    values_[shows_owners_ ? owner : std::string()] += value;
  }
  void write(Exposition& to, std::vector<Label> labels = {}) const {
    for (const auto& [owner, value] : values_) {
      std::vector<Label> all = labels;
      if (shows_owners_) all.emplace_back("owner", owner);
      to.sample(value, all);
    }
  }

private:
  bool shows_owners_;
  std::map<std::string, Value> values_;
};

void add_jobs(Exposition& to, const MetricSources& from) {
  const auto groups = from.context.store.groups();
  std::map<v1::JobState, ByOwner<std::int64_t>> jobs;
  ByOwner<std::int64_t> bytes(from.shows_owners);
  double oldest = 0.0;

  for (const auto& group : groups) {
    jobs.try_emplace(group.state, from.shows_owners).first->second.add(group.owner, group.jobs);
    bytes.add(group.owner, group.bytes);
    if (group.state == v1::QUEUED) oldest = std::max(oldest, seconds_since(group.oldest_ms));
  }

  to.begin("dccast_jobs", "gauge", "Jobs in the store by state and owner.");
  for (const auto& [state, by_owner] : jobs)
    by_owner.write(to, {{"state", v1::JobState_Name(state)}});
  to.begin("dccast_jobs_disk_bytes", "gauge",
           "Disk space of jobs by owner; of a job that has not ended its case alone.");
  bytes.write(to);
  to.gauge("dccast_queue_oldest_wait_seconds", "Age of the oldest job in the queue; 0: none waits.",
           oldest);

  const std::string held = from.context.scheduler.held();
  to.begin("dccast_queue_held", "gauge", "1 while no job starts because of a fault of the server.");
  to.sample(held.empty() ? 0 : 1, {{"reason", held}});
  to.gauge("dccast_jobs_running", "Jobs whose workers run.", from.context.scheduler.running());
  to.gauge("dccast_workers", "Jobs that may run at once.", from.context.workers);
  to.gauge("dccast_quarantined_folders", "Folders without a job.",
           jobs::quarantined_folders(from.context.jobs_directory).size());
}

void add_castings(Exposition& to, service::Context& context) {
  const service::FollowedCastings now = service::followed_castings(context);
  to.gauge("dccast_castings_followed", "Castings that running jobs follow.", now.castings);
  to.gauge("dccast_casting_warnings", "Warnings in the latest forecast of each of them.",
           now.warnings);
  to.gauge("dccast_levers_off_plan", "Levers of these castings that are not as planned now.",
           now.levers_off_plan);
  to.gauge("dccast_reading_age_seconds",
           "Longest time since the last reading of one of them arrived.", now.oldest_reading_s);
}

/// The count of a key; 0 if it was never counted.
template <class Counts>
auto count(const Counts& counts, const typename Counts::key_type& key) {
  const auto found = counts.find(key);
  return found == counts.end() ? typename Counts::mapped_type{} : found->second;
}

void add_tally(Exposition& to, const jobs::TallyFigures& tally, bool shows_owners) {
  to.begin("dccast_job_wait_seconds", "histogram", "From submission to the first start of a job.");
  to.histogram(tally.wait_s);

  to.begin("dccast_job_run_seconds", "histogram",
           "Wall time of a job that has ended, in all its attempts.");
  to.histogram(tally.run_s);

  to.begin("dccast_processor_seconds_total", "counter", "Processor time of ended jobs.");
  ByOwner<double> processor(shows_owners);
  for (const auto& [owner, seconds] : tally.processor_s) processor.add(owner, seconds);
  processor.write(to);

  to.begin("dccast_jobs_ended_total", "counter", "Jobs that have ended, by how.");
  for (const v1::JobState state : {v1::SUCCEEDED, v1::FAILED, v1::CANCELLED})
    to.sample(count(tally.ended, state), {{"state", v1::JobState_Name(state)}});

  to.begin("dccast_job_failures_total", "counter", "Jobs that have failed, by cause.");
  // All kinds from the beginning, so that the first failure of a kind is an increase, too.
  const auto* kinds = v1::Finding::Kind_descriptor();
  for (int i = 1; i < kinds->value_count(); ++i) {
    const auto kind = static_cast<v1::Finding::Kind>(kinds->value(i)->number());
    to.sample(count(tally.failures, kind), {{"cause", kinds->value(i)->name()}});
  }

  to.begin("dccast_findings_total", "counter", "Findings of ended jobs (docs/findings.md).");
  for (const auto& [key, count] : tally.findings)
    to.sample(count, {{"code", key.first}, {"severity", v1::Finding::Severity_Name(key.second)}});
}

void add_calls(Exposition& to, service::Gate& gate) {
  const service::CallFigures calls = gate.figures();

  to.begin("dccast_call_seconds", "histogram",
           "Time to the answer of a call; of a stream until it was open.");
  for (const auto& [key, seconds] : calls.seconds)
    to.histogram(seconds, {{"method", key.first}, {"code", key.second}});

  to.begin("dccast_refused_calls_total", "counter",
           "Calls that a limit has refused, by its setting.");
  for (const auto& [limit, count] : calls.refused) to.sample(count, {{"limit", limit}});

  to.gauge("dccast_streams_open", "Watches, downloads and queries that are open.",
           gate.open_streams());
}

void add_processes(Exposition& to) {
  const auto processes = jobs::child_processes();

  to.begin("dccast_worker_processes", "gauge",
           "Workers that this daemon has started, by their work.");
  for (const auto& [name, total] : processes) to.sample(total.number, {{"name", name}});

  to.begin("dccast_worker_resident_memory_bytes", "gauge", "Their memory.");
  for (const auto& [name, total] : processes) to.sample(total.resident_bytes, {{"name", name}});
  to.gauge("process_resident_memory_bytes", "Memory of the daemon.", jobs::resident_bytes("self"));
}

void add_disk(Exposition& to, const MetricSources& from) {
  const storage::SyncTotals syncs = storage::sync_totals();
  to.begin("dccast_fsync_seconds", "summary", "Waiting for the disk to take files and folders.");
  to.sample(syncs.seconds, {}, "_sum");
  to.sample(syncs.count, {}, "_count");

  struct statvfs disk {};
  if (::statvfs(from.data_directory.c_str(), &disk) == 0) {
    const double block = static_cast<double>(disk.f_frsize);
    to.gauge("dccast_disk_free_bytes", "Free space where the data directory is.",
             block * static_cast<double>(disk.f_bavail));
    to.gauge("dccast_disk_size_bytes", "Size of the file system of the data directory.",
             block * static_cast<double>(disk.f_blocks));
  }

  if (from.certificate.empty()) return;

  const auto certificate = access::read_certificate(
      storage::read_file(from.certificate, storage::Links::follow), from.certificate);
  to.gauge("dccast_certificate_expires_timestamp_seconds",
           "When the certificate of listen.tls ends, since 1970.", certificate.ends_unix);
}

/// A user whose last token has ended is none who waits for a warning.
void add_tokens(Exposition& to, service::Gate& gate, bool shows_owners) {
  const std::int64_t now = jobs::now().seconds();
  std::map<std::string, std::int64_t> ends;
  const v1::Users all = gate.authority().users().users();
  for (const v1::User& user : all.user())
    for (const v1::Credential& token : user.credential()) {
      if (token.enrolment() || token.expires_unix() <= now || user.disabled()) continue;
      const auto [end, is_new] =
          ends.emplace(shows_owners ? user.name() : "", token.expires_unix());
      if (!is_new) end->second = std::min(end->second, token.expires_unix());
    }

  to.begin("dccast_token_expires_timestamp_seconds", "gauge",
           "When the next token of a user ends, since 1970.");
  for (const auto& [user, end] : ends)
    to.sample(end, user.empty() ? Labels{} : Labels{{"user", user}});
}

std::string metrics_text(const MetricSources& sources) {
  Exposition to;
  to.begin("dccast_build_info", "gauge", "1, with the version of the daemon.");
  to.sample(1, {{"version", sources.context.version}});
  add_jobs(to, sources);
  add_castings(to, sources.context);
  add_tally(to, sources.tally.figures(), sources.shows_owners);
  add_calls(to, sources.context.gate);
  add_processes(to);
  add_disk(to, sources);
  add_tokens(to, sources.context.gate, sources.shows_owners);
  return std::move(to).text();
}

/// Names by which a peer on this machine, or at the end of a tunnel, reaches a loopback address.
bool is_loopback_name(const std::string& host, const std::string& listening) {
  const std::string name = values::host_and_port(host).host;
  return name == "localhost" || name == "127.0.0.1" || name == "::1" ||
         name == values::host_and_port(listening).host;
}

/// The page of metrics. It is made once at a time, because it reads the store and files of /proc.
class MetricsPage {
public:
  explicit MetricsPage(MetricSources sources) : sources_(std::move(sources)) {}

  http::Reply reply_to(const http::Request& request) {
    if (request.path == "/alive") return {.body = "ok\n"};
    if (request.path == "/ready") {
      const std::string held = sources_.context.scheduler.held();
      return held.empty() ? http::Reply{.body = "ok\n"}
                          : http::Reply{.body = held + "\n", .status = 503};
    }
    if (request.path != "/metrics" || request.method != "GET")
      return {.body = "Metrics are at /metrics, health at /alive and /ready.\n", .status = 404};
    const std::lock_guard lock(mutex_);
    try {
      return {.body = metrics_text(sources_), .type = "text/plain; version=0.0.4; charset=utf-8"};
    } catch (const std::exception& error) {
      log::error("metrics: {}", error.what());
      return {.body = "The metrics cannot be read; the log of dccastd says why.\n", .status = 500};
    }
  }

private:
  std::mutex mutex_;
  const MetricSources sources_;
};

}  // namespace

std::shared_ptr<void> serve_metrics(const std::string& address, MetricSources sources) {
  if (!values::is_loopback(address))
    throw std::runtime_error(fmt::format(
        "listen.metrics = \"{}\" can be reached from other machines; permitted: a loopback "
        "address such as 127.0.0.1:9117",
        address));

  const auto at = values::host_and_port(address);
  std::shared_ptr<http::Server> server;
  try {
    server = std::make_shared<http::Server>(
        http::Server::Listening{.host = at.host, .port = std::stoi(at.port)}, http::Limits());
  } catch (const http::CannotListen& error) {
    throw std::runtime_error(
        fmt::format("cannot listen on {} for metrics: {}", address, error.what()));
  }

  const auto page = std::make_shared<MetricsPage>(std::move(sources));
  server->start([address](const std::string& host) { return is_loopback_name(host, address); },
                [page](const http::Request& request) { return page->reply_to(request); });
  log::info("metrics on http://{}{}/metrics", address.substr(0, address.rfind(':') + 1),
            server->port());
  return server;
}

}  // namespace dccast::daemon
