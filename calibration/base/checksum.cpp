#include "calibration/base/checksum.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <stdexcept>
#include <vector>

#include "calibration/base/fault.hpp"
#include "calibration/base/system_file.hpp"

namespace ballservo {
namespace {

void require(int result) {
  if (result != 1) throw std::runtime_error("SHA-256 is not available in this OpenSSL");
}

}  // namespace

struct Sha256::State {
  std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context{EVP_MD_CTX_new(), &EVP_MD_CTX_free};
};

Sha256::Sha256() : state_(std::make_unique<State>()) {
  require(state_->context ? EVP_DigestInit_ex(state_->context.get(), EVP_sha256(), nullptr) : 0);
}
Sha256::~Sha256() = default;
Sha256::Sha256(Sha256&&) noexcept = default;
Sha256& Sha256::operator=(Sha256&&) noexcept = default;

void Sha256::add(std::string_view bytes) {
  require(EVP_DigestUpdate(state_->context.get(), bytes.data(), bytes.size()));
}

std::string Sha256::hex() {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned int length = 0;
  require(EVP_DigestFinal_ex(state_->context.get(), digest.data(), &length));
  static constexpr char digits[] = "0123456789abcdef";
  std::string text;
  for (unsigned int i = 0; i < length; ++i) {
    text += digits[digest[i] >> 4];
    text += digits[digest[i] & 15];
  }
  return text;
}

std::string sha256_hex(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

std::string sha256_of_file(const std::filesystem::path& file) {
  // Without waiting: a named pipe without a writer would block for ever.
  const int descriptor = ::open(file.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) throw InputError(file.string(), system_error_text(errno), "a file that can be read");
  struct stat status {};
  std::string problem;
  if (::fstat(descriptor, &status) != 0) problem = system_error_text(errno);
  if (problem.empty() && !S_ISREG(status.st_mode)) problem = "something that is no regular file";
  Sha256 hash;
  std::vector<char> block(std::size_t{1} << 16);
  while (problem.empty()) {
    const ssize_t count = ::read(descriptor, block.data(), block.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) problem = system_error_text(errno);
    if (count <= 0) break;
    hash.add({block.data(), static_cast<std::size_t>(count)});
  }
  ::close(descriptor);
  if (!problem.empty()) throw InputError(file.string(), problem, "a file that can be read");
  return hash.hex();
}

}  // namespace ballservo
