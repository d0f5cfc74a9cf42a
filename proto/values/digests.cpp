#include "proto/values/digests.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/random.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <fstream>
#include <new>
#include <system_error>
#include <vector>

#include "proto/values/owned.hpp"

namespace dccast::values {

namespace {

/// Value of a hexadecimal digit.
bool is_lower_case_digit(char c) {
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'f');
}

constexpr std::size_t uuid_bytes = 16;

/// The UUID of 32 hexadecimal digits, RFC 4122.
std::string uuid_form(std::string text, char version) {
  for (const std::size_t dash : {8, 13, 18, 23}) text.insert(dash, 1, '-');
  text[14] = version;
  // The digit with its two upper bits replaced by those of variant 1.
  text[19] = "89ab"[(text[19] <= '9' ? text[19] - '0' : text[19] - 'a' + 10) & 3];
  return text;
}

}  // namespace

struct Sha256::Context {
  Owned<EVP_MD_CTX, EVP_MD_CTX_free> digest{EVP_MD_CTX_new()};
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (!context_->digest || EVP_DigestInit_ex(context_->digest.get(), EVP_sha256(), nullptr) != 1)
    throw std::bad_alloc();
}

Sha256::~Sha256() = default;

void Sha256::add(std::string_view bytes) {
  EVP_DigestUpdate(context_->digest.get(), bytes.data(), bytes.size());
}

std::string Sha256::finish() {
  std::array<unsigned char, 32> digest;
  EVP_DigestFinal_ex(context_->digest.get(), digest.data(), nullptr);
  return hexadecimal(digest);
}

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
  // getrandom(2) delivers up to 256 bytes at once, without interruption.
  if (getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size()))
    throw std::system_error(errno, std::generic_category(), "getrandom");
  return hexadecimal(random);
}

std::string sha256(std::string_view bytes) {
  Sha256 digest;
  digest.add(bytes);
  return digest.finish();
}

std::string sha256_of_file(const std::filesystem::path& path, std::int64_t most) {
  const auto fail = [&] {
    return std::system_error(errno, std::generic_category(),
                             fmt::format("cannot read {}", path.string()));
  };
  if (std::filesystem::exists(path) && !std::filesystem::is_regular_file(path)) {
    errno = EINVAL;  // a named pipe would be waited for
    throw fail();
  }
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail();

  Sha256 digest;
  std::vector<char> piece(1 << 18);
  while (file && most > 0) {
    file.read(piece.data(), std::min(most, static_cast<std::int64_t>(piece.size())));
    digest.add({piece.data(), static_cast<std::size_t>(file.gcount())});
    most -= file.gcount();
  }
  if (file.bad()) throw fail();

  return digest.finish();
}

std::string random_uuid() {
  return uuid_form(random_hexadecimal(uuid_bytes), '4');
}

std::string uuid_of(std::string_view name) {
  // Random once: names of other programs have another namespace.
  constexpr std::array<unsigned char, uuid_bytes> name_space{0x5c, 0x1b, 0xe9, 0x0a, 0x7d, 0x42,
                                                             0x4f, 0x06, 0x9a, 0x33, 0x60, 0xd8,
                                                             0x2e, 0xb7, 0x91, 0xc4};
  std::string bytes(name_space.begin(), name_space.end());
  bytes += name;

  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  if (EVP_Digest(bytes.data(), bytes.size(), digest.data(), nullptr, EVP_sha1(), nullptr) != 1)
    throw std::bad_alloc();
  return uuid_form(hexadecimal({digest.data(), uuid_bytes}), '5');
}

bool is_uuid(std::string_view text) {
  constexpr std::string_view form = "hhhhhhhh-hhhh-hhhh-hhhh-hhhhhhhhhhhh";
  const auto fits = [](char c, char wanted) {
    return wanted == '-' ? c == '-' : is_lower_case_digit(c);
  };
  return std::ranges::equal(text, form, fits);
}

bool is_sha256(std::string_view text) {
  constexpr std::size_t length = 64;
  return text.size() == length && std::ranges::all_of(text, is_lower_case_digit);
}

}  // namespace dccast::values
