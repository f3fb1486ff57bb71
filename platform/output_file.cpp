#include "output_file.hpp"

#include <fmt/format.h>

#include <cerrno>
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

void OutputFile::write(const void* data, std::size_t octets) {
  if (octets != 0 && std::fwrite(data, 1, octets, stream_.get()) != octets) {
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

void write_file(const std::filesystem::path& file, std::string_view text) {
  const std::filesystem::path beside = file.string() + ".new";
  std::error_code problem;
  std::filesystem::remove(beside, problem);
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
