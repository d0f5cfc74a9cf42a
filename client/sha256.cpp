#include "client/sha256.hpp"

#include <fstream>
#include <memory>
#include <vector>

#include <openssl/evp.h>

#include "client/failure.hpp"

namespace dccast::client {

std::string sha256_of_file(const std::filesystem::path& file) {
  const std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> digest(EVP_MD_CTX_new(),
                                                                       EVP_MD_CTX_free);
  std::ifstream stream(file, std::ios::binary);
  if (!stream || digest == nullptr || EVP_DigestInit_ex(digest.get(), EVP_sha256(), nullptr) != 1)
    throw CommandFailed(ExitCode::not_found, "cannot read " + file.string());
  std::vector<char> block(1 << 20);
  while (stream) {
    stream.read(block.data(), static_cast<std::streamsize>(block.size()));
    EVP_DigestUpdate(digest.get(), block.data(), static_cast<std::size_t>(stream.gcount()));
  }
  unsigned char sum[EVP_MAX_MD_SIZE];
  unsigned length = 0;
  EVP_DigestFinal_ex(digest.get(), sum, &length);
  static constexpr char hex[] = "0123456789abcdef";
  std::string text;
  for (unsigned i = 0; i < length; ++i) {
    text += hex[sum[i] >> 4];
    text += hex[sum[i] & 0xF];
  }
  return text;
}

}  // namespace dccast::client
