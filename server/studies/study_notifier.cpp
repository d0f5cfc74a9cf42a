#include "server/studies/study_notifier.hpp"

#include <chrono>
#include <utility>

namespace dccast::studies {

namespace {

constexpr std::chrono::seconds progress_interval{1};
// Many jobs of a sweep may end within this: one look at the study tells of all of them.
constexpr std::chrono::milliseconds gathering{20};

}  // namespace

StudyNotifier::StudyNotifier() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

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

void StudyNotifier::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    const bool woken =
        changed_.wait_for(lock, stop, progress_interval, [this] { return !news_.empty(); });
    if (woken) changed_.wait_for(lock, stop, gathering, [] { return false; });
    const auto watchers = due(!woken);
    lock.unlock();
    for (const auto& watcher : watchers) watcher->on_changed();
    lock.lock();
  }
}

}  // namespace dccast::studies
