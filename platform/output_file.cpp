#include "output_file.hpp"

#include <fmt/format.h>

#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>

#include "errors.hpp"

namespace polhode::platform {

OutputFile::OutputFile(const std::filesystem::path& file,
                       const char* mode,
                       const std::filesystem::path& named)
    : name_(named.string()), stream_(std::fopen(file.c_str(), mode)) {
  if (!stream_) {
    fail();
  }
}

void OutputFile::write(const void* data, std::size_t bytes) {
  if (bytes != 0 && std::fwrite(data, 1, bytes, stream_.get()) != bytes) {
    fail();
  }
}

void OutputFile::close() {
  std::FILE* stream = stream_.release();
  if (stream != nullptr && std::fclose(stream) != 0) {
    fail();
  }
}

void OutputFile::fail() const {
  throw RunFailure(
      fmt::format("{}: cannot be written: {}", name_, std::generic_category().message(errno)));
}

std::filesystem::path fresh_beside(const std::filesystem::path& file) {
  namespace fs = std::filesystem;
  std::error_code problem;
  for (long number = ::getpid();; ++number) {
    fs::path beside = fmt::format("{}.{}.new", file.string(), number);
    const fs::file_type type = fs::symlink_status(beside, problem).type();
    if (type == fs::file_type::not_found || type == fs::file_type::none) {
      return beside;
    }
  }
}

void write_file(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path beside = fresh_beside(file);
  std::error_code problem;
  OutputFile out(beside, "wbxe", file);  // made here: nobody's link is followed
  try {
    out.write(text);
    out.close();
    std::filesystem::rename(beside, file, problem);
    if (problem) {
      errno = problem.value();
      out.fail();
    }
  } catch (...) {
    std::filesystem::remove(beside, problem);
    throw;
  }
}

}  // namespace polhode::platform
