#include "proto/values/digests.hpp"

#include <openssl/evp.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <memory>
#include <new>
#include <system_error>
#include <vector>

namespace dccast::values {

std::string hexadecimal(std::span<const unsigned char> bytes) {
  std::string text;
  for (const unsigned char byte : bytes) {
    text += "0123456789abcdef"[byte >> 4];
    text += "0123456789abcdef"[byte & 15];
  }
  return text;
}

std::string random_hexadecimal(std::size_t bytes) {
  std::vector<unsigned char> random(bytes);
  // Up to 256 bytes come at once and without interruption, getrandom(2).
  if (getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    throw std::system_error(errno, std::generic_category(), "getrandom");
  return hexadecimal(random);
}

namespace {

/// Takes bytes piece by piece and gives their SHA-256.
class Sha256 {
public:
  Sha256() : context_(EVP_MD_CTX_new(), &EVP_MD_CTX_free) {
    if (!context_ || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1)
      throw std::bad_alloc();
  }
  void take(const void* bytes, std::size_t size) { EVP_DigestUpdate(context_.get(), bytes, size); }
  std::string in_hexadecimal() {
    std::array<unsigned char, 32> digest;
    EVP_DigestFinal_ex(context_.get(), digest.data(), nullptr);
    return hexadecimal(digest);
  }

private:
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

}  // namespace

std::string sha256(std::string_view bytes) {
  Sha256 digest;
  digest.take(bytes.data(), bytes.size());
  return digest.in_hexadecimal();
}

std::string sha256_of_file(const std::filesystem::path& path, std::int64_t most) {
  const auto fail = [&] {
    return std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  };
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail();
  Sha256 digest;
  std::vector<char> piece(1 << 18);
  while (file && most > 0) {
    file.read(piece.data(), std::min(most, static_cast<std::int64_t>(piece.size())));
    digest.take(piece.data(), static_cast<std::size_t>(file.gcount()));
    most -= file.gcount();
  }
  if (file.bad()) throw fail();
  return digest.in_hexadecimal();
}

namespace {

constexpr bool is_dash(std::size_t i) {
  return i == 8 || i == 13 || i == 18 || i == 23;
}

/// The digit with its two upper bits replaced by those of variant 1.
char of_variant_1(char digit) {
  return "89ab"[(digit <= '9' ? digit - '0' : digit - 'a' + 10) & 3];
}

}  // namespace

std::string random_uuid() {
  std::string text = random_hexadecimal(16);
  for (const std::size_t dash : {8, 13, 18, 23}) text.insert(dash, 1, '-');
  text[14] = '4';  // version 4, RFC 4122
  text[19] = of_variant_1(text[19]);
  return text;
}

bool is_uuid(std::string_view text) {
  if (text.size() != 36) return false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool digit = (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
    if (is_dash(i) ? c != '-' : !digit) return false;
  }
  return true;
}

}  // namespace dccast::values
