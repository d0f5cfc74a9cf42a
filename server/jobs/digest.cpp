#include "server/jobs/digest.hpp"

#include <fcntl.h>
#include <openssl/evp.h>

#include <array>
#include <memory>
#include <new>
#include <vector>

#include "server/jobs/durable_file.hpp"

namespace dccast::jobs {

namespace {

constexpr std::array<std::uint32_t, 256> crc32c_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t remainder = byte;
    for (int bit = 0; bit < 8; ++bit)
      remainder = (remainder >> 1) ^ ((remainder & 1) ? 0x82f63b78u : 0u);
    table[byte] = remainder;
  }
  return table;
}

/// Takes bytes piece by piece and gives their SHA-256.
class Sha256 {
public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw std::bad_alloc();
  }
  void take(const void* bytes, std::size_t size) { EVP_DigestUpdate(context_.get(), bytes, size); }
  std::string hexadecimal() {
    std::array<unsigned char, 32> digest;
    EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr);
    std::string text;
    for (const unsigned char byte : digest) {
      text += "0123456789abcdef"[byte >> 4];
      text += "0123456789abcdef"[byte & 15];
    }
    return text;
  }

private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::uint32_t crc32c(std::string_view bytes) {
  static constexpr auto table = crc32c_table();
  std::uint32_t remainder = ~0u;
  for (const char c : bytes)
    remainder = (remainder >> 8) ^ table[(remainder ^ static_cast<unsigned char>(c)) & 0xff];
  return ~remainder;
}

std::string sha256(std::string_view bytes) {
  Sha256 digest;
  digest.take(bytes.data(), bytes.size());
  return digest.hexadecimal();
}

std::string sha256_of_file(const std::filesystem::path& path) {
  const FileDescriptor file = open_file(path, O_RDONLY);
  Sha256 digest;
  std::vector<char> piece(1 << 18);
  for (std::int64_t offset = 0;;) {
    const std::size_t got = read_at(file.get(), offset, piece);
    if (got == 0) return digest.hexadecimal();
    digest.take(piece.data(), got);
    offset += static_cast<std::int64_t>(got);
  }
}

}  // namespace dccast::jobs
