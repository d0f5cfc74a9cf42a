#pragma once

#include <cstddef>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

namespace dccast::jobs {

/// What was asked for last, by name, as long as it is not more than `most` in all: bytes, or pieces
/// where each has the size 1. Safe to use from several threads.
template <class Value>
class Recent {
public:
  explicit Recent(std::size_t most) : most_(most) {}

  /// @return null when it is not kept
  std::shared_ptr<Value> find(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = entries_.find(name);
    if (found == entries_.end()) return nullptr;
    order_.splice(order_.begin(), order_, found->second.place);
    return found->second.value;
  }

  /// Keeps a value, unless it is too large, and drops those asked for longest ago.
  /// @return the one that is there already under this name; else `value`
  std::shared_ptr<Value> keep(const std::string& name, std::shared_ptr<Value> value,
                              std::size_t size = 1) {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(name); found != entries_.end()) return found->second.value;
    if (size > most_) return value;
    while (size_ + size > most_) drop(entries_.find(order_.back()));
    order_.push_front(name);
    entries_[name] = {value, size, order_.begin()};
    size_ += size;
    return value;
  }

  /// Drops a value, for instance because what it was made from has changed.
  void forget(const std::string& name) {
    const std::lock_guard lock(mutex_);
    if (const auto found = entries_.find(name); found != entries_.end()) drop(found);
  }

private:
  /// A value, its size, and its place in the order of use.
  struct Entry {
    std::shared_ptr<Value> value;
    std::size_t size = 0;
    std::list<std::string>::iterator place;
  };

  void drop(typename std::map<std::string, Entry>::iterator entry) {
    size_ -= entry->second.size;
    order_.erase(entry->second.place);
    entries_.erase(entry);
  }

  const std::size_t most_;
  std::mutex mutex_;
  std::map<std::string, Entry> entries_;
  std::list<std::string> order_;  ///< names, the one used last in front
  std::size_t size_ = 0;
};

}  // namespace dccast::jobs
