#include "parameters/sha256.hpp"

#include <fmt/format.h>
#include <openssl/evp.h>

#include <array>

#include "errors.hpp"

namespace polhode::platform {

struct Sha256::Context {
  EVP_MD_CTX* handle = EVP_MD_CTX_new();
};

Sha256::Sha256() : context_(std::make_unique<Context>()) {
  if (context_->handle == nullptr ||
      EVP_DigestInit_ex(context_->handle, EVP_sha256(), nullptr) != 1) {
    throw RunFailure("SHA-256 is not available in libcrypto");
  }
}

Sha256::~Sha256() { EVP_MD_CTX_free(context_->handle); }

void Sha256::add(std::span<const std::uint8_t> bytes) {
  if (!bytes.empty()) {
    EVP_DigestUpdate(context_->handle, bytes.data(), bytes.size());
  }
}

std::string Sha256::finish() {
  std::array<std::uint8_t, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  EVP_DigestFinal_ex(context_->handle, digest.data(), &size);
  std::string hex;
  for (unsigned i = 0; i < size; ++i) {
    hex += fmt::format("{:02x}", digest[i]);
  }
  return hex;
}

std::string sha256_of(std::string_view text) {
  Sha256 hash;
  hash.add({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  return hash.finish();
}

}  // namespace polhode::platform
