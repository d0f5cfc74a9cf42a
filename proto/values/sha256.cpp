#include "proto/values/sha256.hpp"

#include <openssl/evp.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <memory>
#include <new>
#include <system_error>
#include <vector>

#include "proto/values/hexadecimal.hpp"

namespace dccast::values {

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

std::string sha256_of_file(const std::filesystem::path& path) {
  const auto fail = [&] {
    return std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  };
  std::ifstream file(path, std::ios::binary);
  if (!file) throw fail();
  Sha256 digest;
  std::vector<char> piece(1 << 18);
  while (file) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    digest.take(piece.data(), static_cast<std::size_t>(file.gcount()));
  }
  if (file.bad()) throw fail();
  return digest.in_hexadecimal();
}

}  // namespace dccast::values
