#include "client/web/event_stream.hpp"

#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>

#include "client/model/json.hpp"

namespace dccast::client::web {
namespace {

constexpr std::size_t most_waiting = 1000;  // events that a slow browser has not taken
// At this interval a comment shows whether the browser is still there, and a server that stops is
// noticed.
constexpr std::chrono::milliseconds pulse{500};

}  // namespace

/// Events on their way from their source to the browser.
class EventStream::Mailbox {
public:
  /// Waits while the browser has many to take. Throws Interrupted once it has gone.
  void put(std::string text) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return gone_ || waiting_.size() < most_waiting; });
    if (gone_) throw Interrupted("");
    waiting_.push_back(std::move(text));
    changed_.notify_all();
  }
  void end() {
    const std::lock_guard lock(mutex_);
    ended_ = true;
    changed_.notify_all();
  }
  void leave() {
    const std::lock_guard lock(mutex_);
    gone_ = true;
    changed_.notify_all();
  }
  std::string take() {
    std::unique_lock lock(mutex_);
    changed_.wait_for(lock, pulse, [&] { return ended_ || !waiting_.empty(); });
    std::string text;
    for (const std::string& event : waiting_) text += event;
    waiting_.clear();
    if (text.empty() && !ended_) text = ": still here\n\n";
    changed_.notify_all();
    return text;
  }

private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::string> waiting_;
  bool ended_ = false, gone_ = false;
};

EventStream::EventStream(Source source)
    : box_(std::make_unique<Mailbox>()),
      thread_([this, source = std::move(source)] { run(source); }) {}

EventStream::~EventStream() {
  box_->leave();
  gone_->come();
  thread_.join();
}

std::string EventStream::take() {
  return box_->take();
}

void EventStream::run(const Source& source) {
  try {
    source(gone_, [&](const std::string& json) { box_->put("data: " + json + "\n\n"); });
  } catch (const Interrupted&) {
  } catch (const std::exception& error) {
    try {
      box_->put("event: fault\ndata: " + Json{{"error", error.what()}}.dump() + "\n\n");
    } catch (const Interrupted&) {
    }
  }
  box_->end();
}

}  // namespace dccast::client::web
