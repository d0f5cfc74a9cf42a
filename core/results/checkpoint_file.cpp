#include "core/results/checkpoint_file.hpp"

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <utility>

#include "core/storage/file.hpp"
#include "core/storage/record_log.hpp"

namespace dccast::results {

namespace {

constexpr std::uint32_t current_version = 1;

/// The first bytes of a checkpoint; see CHECKPOINT.md.
struct Preamble {
  char magic[8] = {'D', 'C', 'C', 'K', 'P', 'T', '\r', '\n'};
  std::uint32_t version = current_version;
  std::uint32_t checksum = 0;  ///< CRC-32C of the content
  std::uint64_t size = 0;      ///< of the content, in bytes
};
static_assert(sizeof(Preamble) == 24);

bool has_magic(const Preamble& preamble) {
  return std::memcmp(preamble.magic, Preamble{}.magic, sizeof preamble.magic) == 0;
}

bool has_other_format(const Preamble& preamble) {
  return has_magic(preamble) && preamble.version != current_version;
}

std::string describe_format(std::uint32_t version) {
  return fmt::format("checkpoint format {}; this program reads format {}", version,
                     current_version);
}

/// The reason why the bytes are not a checkpoint; empty if they are one.
std::string find_fault(const Preamble& preamble, std::string_view content) {
  if (!has_magic(preamble)) return "not a checkpoint";
  if (content.size() != preamble.size) return "truncated";
  if (storage::crc32c(content.data(), content.size()) != preamble.checksum) return "checksum";
  return "";
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Sections& content) {
  const std::string body = encode(content);
  Preamble preamble;
  preamble.checksum = storage::crc32c(body.data(), body.size());
  preamble.size = body.size();
  std::string bytes(reinterpret_cast<const char*>(&preamble), sizeof preamble);
  storage::replace_file(path, bytes += body, storage::readable_by_all);
}

CheckpointRead read_checkpoint(const std::filesystem::path& path) {
  if (!std::filesystem::exists(path)) return {std::nullopt, "missing"};
  const std::string bytes = storage::read_file(path);

  // The preamble is checked before anything in the body is trusted.
  Preamble preamble;
  if (bytes.size() < sizeof preamble) return {std::nullopt, "truncated"};
  std::memcpy(&preamble, bytes.data(), sizeof preamble);
  if (has_other_format(preamble)) return {std::nullopt, describe_format(preamble.version), true};

  const std::string_view body = std::string_view(bytes).substr(sizeof preamble);
  if (std::string fault = find_fault(preamble, body); !fault.empty())
    return {std::nullopt, std::move(fault)};
  auto content = decode(body);
  if (!content) return {std::nullopt, "not a checkpoint"};
  return {std::move(content), ""};
}

}  // namespace dccast::results
