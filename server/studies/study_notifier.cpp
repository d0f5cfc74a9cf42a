#include "server/studies/study_notifier.hpp"

#include <chrono>
#include <utility>

namespace dccast::studies {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds progress_interval{1};
constexpr std::chrono::milliseconds look_interval{50};

}  // namespace

StudyNotifier::StudyNotifier(std::function<std::int64_t()> version)
    : version_(std::move(version)), thread_([this](const std::stop_token& stop) { run(stop); }) {}

StudyNotifier::~StudyNotifier() = default;

void StudyNotifier::watch(const std::string& study, std::weak_ptr<StudyWatcher> watcher) {
  const std::lock_guard lock(mutex_);
  watchers_[study].push_back(std::move(watcher));
  news_.insert(study);
  changed_.notify_all();
}

void StudyNotifier::note(const std::string& study) {
  const std::lock_guard lock(mutex_);
  if (!watchers_.contains(study)) return;
  news_.insert(study);
  changed_.notify_all();
}

void StudyNotifier::wake_all() {
  const std::lock_guard lock(mutex_);
  for (const auto& [study, watchers] : watchers_) news_.insert(study);
  changed_.notify_all();
}

std::vector<std::shared_ptr<StudyWatcher>> StudyNotifier::due(bool all) {
  std::vector<std::shared_ptr<StudyWatcher>> found;
  const std::set<std::string> news = std::exchange(news_, {});
  for (auto at = watchers_.begin(); at != watchers_.end();) {
    std::erase_if(at->second, [](const auto& watcher) { return watcher.expired(); });
    if (all || news.contains(at->first))
      for (const auto& watcher : at->second)
        if (auto alive = watcher.lock()) found.push_back(std::move(alive));
    at = at->second.empty() ? watchers_.erase(at) : std::next(at);
  }
  return found;
}

/// A store that cannot be read now says nothing; watchers are woken every second all the same.
bool StudyNotifier::jobs_have_changed() {
  try {
    const std::int64_t version = version_();
    return std::exchange(seen_version_, version) != version;
  } catch (const std::exception&) {
    return false;
  }
}

void StudyNotifier::run(const std::stop_token& stop) {
  auto told = Clock::now();
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    changed_.wait(lock, stop, [this] { return !watchers_.empty(); });
    changed_.wait_for(lock, stop, look_interval, [this] { return !news_.empty(); });
    lock.unlock();
    const bool all = jobs_have_changed() || Clock::now() - told > progress_interval;
    lock.lock();
    const auto watchers = due(all);
    lock.unlock();
    for (const auto& watcher : watchers) watcher->on_changed();
    if (all) told = Clock::now();
    lock.lock();
  }
}

}  // namespace dccast::studies
