#include "core/storage/durable_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

#include "core/storage/storage_error.hpp"

namespace dccast::storage {

namespace fs = std::filesystem;

void sync_directory(const fs::path& directory) {
  const fs::path named = directory.empty() ? fs::path(".") : directory;
  const File opened(named, O_RDONLY | O_DIRECTORY);
  if (::fsync(opened.descriptor()) != 0)
    throw StorageError(errno, named.string(), "cannot be synchronised");
}

void create_durably(const fs::path& path, std::string_view content) {
  const File file(path, O_WRONLY | O_CREAT | O_EXCL);
  file.write_at(0, content);
  file.sync();
}

void publish(std::initializer_list<Publication> files) {
  for (const Publication& file : files) File(file.finished, O_RDONLY).sync();
  for (const auto& [finished, final_path] : files)
    if (std::rename(finished.c_str(), final_path.c_str()) != 0)
      throw StorageError(errno, final_path.string(), "cannot be given its final name");
  sync_directory(files.begin()->final_path.parent_path());
}

void replace_file(const fs::path& path, std::string_view content, mode_t permissions) {
  fs::path temporary = path;
  temporary += ".tmp";
  write_file(temporary, content, permissions);
  publish({{temporary, path}});
}

}  // namespace dccast::storage
