#include "server/studies/study_notifier.hpp"

#include <chrono>
#include <utility>

namespace dccast::studies {

namespace {

using Clock = std::chrono::steady_clock;

constexpr std::chrono::seconds progress_interval{1};
constexpr std::chrono::milliseconds least_interval{50};

}  // namespace

StudyNotifier::StudyNotifier() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

void StudyNotifier::watch(const std::string& study, std::weak_ptr<StudyWatcher> watcher) {
  const std::lock_guard lock(mutex_);
  watchers_[study].push_back(std::move(watcher));
  changed_studies_.insert(study);
  wake_.notify_all();
}

void StudyNotifier::note(const std::string& study) {
  const std::lock_guard lock(mutex_);
  if (!watchers_.contains(study)) return;
  changed_studies_.insert(study);
  wake_.notify_all();
}

void StudyNotifier::wake_all() {
  const std::lock_guard lock(mutex_);
  for (const auto& [study, watchers] : watchers_) changed_studies_.insert(study);
  wake_.notify_all();
}

std::vector<std::shared_ptr<StudyWatcher>> StudyNotifier::due(bool every_study) {
  std::vector<std::shared_ptr<StudyWatcher>> found;
  const std::set<std::string> changed = std::exchange(changed_studies_, {});
  for (auto entry = watchers_.begin(); entry != watchers_.end();) {
    std::erase_if(entry->second, [](const auto& watcher) { return watcher.expired(); });
    if (every_study || changed.contains(entry->first))
      for (const auto& watcher : entry->second)
        if (auto alive = watcher.lock()) found.push_back(std::move(alive));
    entry = entry->second.empty() ? watchers_.erase(entry) : std::next(entry);
  }
  return found;
}

void StudyNotifier::run(const std::stop_token& stop) {
  auto last_of_all = Clock::now();
  std::unique_lock lock(mutex_);
  while (!stop.stop_requested()) {
    wake_.wait(lock, stop, [this] { return !watchers_.empty(); });

    wake_.wait_until(lock, stop, last_of_all + progress_interval,
                     [this] { return !changed_studies_.empty(); });

    // Watchers of all studies are due once per interval, because progress changes no row.
    const bool every_study = Clock::now() >= last_of_all + progress_interval;
    if (every_study) last_of_all = Clock::now();
    const auto watchers = due(every_study);

    lock.unlock();
    for (const auto& watcher : watchers) watcher->on_changed();
    lock.lock();

    wake_.wait_for(lock, stop, least_interval, [] { return false; });  // or the end
  }
}

}  // namespace dccast::studies
