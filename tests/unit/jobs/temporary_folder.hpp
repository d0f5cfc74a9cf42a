#pragma once

#include <stdlib.h>

#include <filesystem>
#include <string>

/// A folder that is gone at the end of a test, with what was put beside it (a quarantine).
class TemporaryFolder {
public:
  TemporaryFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "dccast-jobs-XXXXXX").string();
    if (::mkdtemp(name.data()) != nullptr) path_ = std::filesystem::path(name) / "folder";
    std::filesystem::create_directory(path_);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  ~TemporaryFolder() { std::filesystem::remove_all(path_.parent_path()); }
  const std::filesystem::path& path() const { return path_; }

private:
  std::filesystem::path path_;
};
